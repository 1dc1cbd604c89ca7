/** Throws an error with the place, the value that was read and the valid values. */
export function refuse(place: string, found: unknown, allowed: unknown): never {
    throw new Error(`${place}: found ${found}, expected ${allowed}`);
}

/** Throws an error with the place, a problem that is not a value, and what would be valid. */
export function refuseProblem(place: string, problem: string, allowed: string): never {
    throw new Error(`${place}: ${problem}; expected ${allowed}`);
}
