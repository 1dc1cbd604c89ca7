/** Throws an error with the place, the found and the expected value. */
export function refuse(place: string, found: unknown, allowed: unknown): never {
    throw new Error(`${place}: found ${found}, expected ${allowed}`);
}
