/** Throws what is wrong, where, and what would be right. */
export function refuse(place: string, found: unknown, allowed: unknown): never {
    throw new Error(`${place}: found ${found}, expected ${allowed}`);
}
