// What a node takes over from the coarser level. The CPU twin is `render/adaptive/upsample.rs`.

fn stands_for(level: u32, index: u32) -> u32 {
    let own = picture.levels[level];
    if level > 0u {
        let middle = (vec2<u32>(index % own.x, index / own.x) << vec2<u32>(level)) + vec2<u32>(1u << (level - 1u));
        if all(middle < picture.points) {
            let point = middle.y * picture.points.x + middle.x;
            if part_of(point) != NONE {
                return point;
            }
        }
    }
    return nodes[own.z + index].first;
}

fn taken(point: u32, index: u32, level: u32) -> vec4<f32> {
    return vec4<f32>(0.0);
}
