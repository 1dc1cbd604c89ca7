// Computes a level of nodes from the next finer one. The CPU twin is `crates/render/src/adaptive/pyramid.rs`.

@compute @workgroup_size(64)
fn merge(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let own = rendering.levels[job.level];
    let finer = rendering.levels[job.level - 1u];
    let index = job.first + at;
    let left = 2u * (index % own.x);
    let above = 2u * (index / own.x);
    let right = min(left + 1u, finer.x - 1u);
    let below = min(above + 1u, finer.y - 1u);
    let upper = merged(nodes[finer.z + above * finer.x + left], nodes[finer.z + above * finer.x + right]);
    let lower = merged(nodes[finer.z + below * finer.x + left], nodes[finer.z + below * finer.x + right]);
    nodes[own.z + index] = merged(upper, lower);
}

fn merged(a: Node, b: Node) -> Node {
    return Node(min(a.finest, b.finest), max(a.samples, b.samples), min(a.first, b.first));
}
