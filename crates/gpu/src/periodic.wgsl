// Periodic indices.

fn wrapped(index: i32, size: i32) -> i32 {
    let rest = index % size;
    return select(rest, rest + size, rest < 0);
}
