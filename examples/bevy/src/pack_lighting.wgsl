// Bevy's lights, and an environment, for packs. Include it after the decoders of environments and lobes, the variable
// `pack_settings`, another decoder and two functions:
//
//     pack_level(uv)               // a level of detail, where control flow is uniform
//     pack_reflected(surface, wi)  // f_r times the cosine of the incoming direction, 1/sr
//
// PACK_LOBES is defined if there are lobes and an environment, PACK_BACKGROUND if there is only an environment.

#import bevy_pbr::{
    clustered_forward as clusters,
    forward_io,
    mesh_bindings,
    mesh_types,
    mesh_view_bindings as scene,
    mesh_view_types as flags,
    pbr_functions,
    pbr_types,
    shadows,
}

// Minimum cosine between normal and viewer: at outlines, interpolated normals would face away.
const LOWEST_VIEW: f32 = 0.02;

// A point of the surface.
struct PackSurface {
    frame: mat3x3<f32>,  // tangent, bitangent and normal, in the world
    wo: vec3<f32>,       // to the viewer, in the frame
    distance: f32,       // from the viewer
    uv: vec2<f32>,       // as textures have it: v goes down
    level: f32,          // the result of `pack_level`
}

@fragment
fn fragment(in: forward_io::VertexOutput, @builtin(front_facing) front: bool) -> forward_io::FragmentOutput {
#ifdef VERTEX_UVS_A
    let uv = in.uv;
#else
    let uv = vec2<f32>(0.0);
#endif
    let level = pack_level(uv);
    let is_orthographic = scene::view.clip_from_view[3].w == 1.0;
    let surface = surface_at(in, front, is_orthographic, uv, level);
    let position = in.world_position.xyz;
    let normal = in.world_normal;
    let mesh_flags = mesh_bindings::mesh[in.instance_index].flags;
    let receives_shadows = (mesh_flags & mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT) != 0u;
    var radiance = vec3<f32>(0.0);

    let view_z = (scene::view.view_from_world * in.world_position).z;
    let cluster = clusters::view_fragment_cluster_index(in.position.xy, view_z, is_orthographic);
    let ranges = clusters::unpack_clusterable_object_index_ranges(cluster);
    for (var k = ranges.first_point_light_index_offset; k < ranges.first_spot_light_index_offset; k += 1u) {
        let id = clusters::get_clusterable_object_id(k);
        var share = 1.0;
        if receives_shadows && near_light_throws_shadows(id) {
            share = shadows::fetch_point_shadow(id, in.world_position, normal, in.position.xy);
        }
        radiance += share * from_near_light(surface, position, id);
    }
    for (var k = ranges.first_spot_light_index_offset; k < ranges.first_reflection_probe_index_offset; k += 1u) {
        let id = clusters::get_clusterable_object_id(k);
        let near_z = scene::clustered_lights.data[id].shadow_map_near_z;
        var share = cone(position, id);
        if receives_shadows && near_light_throws_shadows(id) {
            share *= shadows::fetch_spot_shadow(id, in.world_position, normal, near_z, in.position.xy);
        }
        radiance += share * from_near_light(surface, position, id);
    }
    for (var k = 0u; k < scene::lights.n_directional_lights; k += 1u) {
        let light_flags = scene::lights.directional_lights[k].flags;
        var share = 1.0;
        if receives_shadows && (light_flags & flags::DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) != 0u {
            share = shadows::fetch_directional_shadow(k, in.world_position, normal, view_z, in.position.xy);
        }
        let irradiance = scene::lights.directional_lights[k].color.rgb;
        radiance += share * reflected(surface, scene::lights.directional_lights[k].direction_to_light, irradiance);
    }

#ifdef PACK_LOBES
    radiance += from_environment(surface);
#endif
#ifdef PACK_BACKGROUND
    let away = -pbr_functions::calculate_view(in.world_position, is_orthographic);
    radiance = pack_settings.intensity * environment_radiance(turned(away), environment_parameters.sharpest);
#endif

    // Fog, and tone mapping if the view has no HDR texture.
    var input = pbr_types::pbr_input_new();
    input.frag_coord = in.position;
    input.world_position = in.world_position;
    input.is_orthographic = is_orthographic;
    input.material.flags |= pbr_types::STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT;
    var out: forward_io::FragmentOutput;
    out.color = pbr_functions::main_pass_post_lighting_processing(
        input, vec4<f32>(scene::view.exposure * radiance, 1.0));
    return out;
}

// The local frame: two-sided, and turned towards the viewer at outlines.
fn surface_at(
    in: forward_io::VertexOutput, front: bool, is_orthographic: bool, uv: vec2<f32>, level: f32
) -> PackSurface {
    let v = pbr_functions::calculate_view(in.world_position, is_orthographic);
    var n = normalize(in.world_normal);
    if !front {
        n = -n;
    }
    let cosine = dot(n, v);
    if cosine < LOWEST_VIEW {
        n = normalize(n + v * (LOWEST_VIEW - cosine));
    }
#ifdef VERTEX_TANGENTS
    let along = in.world_tangent.xyz;
    let side = select(1.0, -1.0, in.world_tangent.w < 0.0);
#else
    // Any direction is sufficient.
    let along = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), abs(n.x) > 0.7);
    let side = 1.0;
#endif
    let t = normalize(along - n * dot(n, along));
    let frame = mat3x3<f32>(t, side * cross(n, t), n);
    let distance = length(scene::view.world_position.xyz - in.world_position.xyz);
    return PackSurface(frame, v * frame, distance, uv, level);
}

// Radiance from `irradiance`, measured perpendicular to the unit vector `l` to the light.
fn reflected(surface: PackSurface, l: vec3<f32>, irradiance: vec3<f32>) -> vec3<f32> {
    let wi = l * surface.frame;
    if wi.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    return pack_reflected(surface, wi) * irradiance;
}

// The direction in the frame of the environment, which is turned about the y axis.
fn turned(direction: vec3<f32>) -> vec3<f32> {
    let turn = pack_settings.turn;
    return vec3<f32>(
        turn.x * direction.x - turn.y * direction.z,
        direction.y,
        turn.y * direction.x + turn.x * direction.z,
    );
}

#ifdef PACK_LOBES
// Radiance that lobes reflect from the environment.
fn from_environment(surface: PackSurface) -> vec3<f32> {
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < lobes_count(); k += 1u) {
        let lobe = lobes_lookup(surface.wo, k);
        radiance += lobe.weight * environment_radiance(turned(surface.frame * lobe.direction), lobe.sharpness);
    }
    return pack_settings.intensity * radiance;
}
#endif

// A point or spot light without its cone, treated as a point with any radius. Bevy's lights end at their range.
fn from_near_light(surface: PackSurface, position: vec3<f32>, id: u32) -> vec3<f32> {
    let to_light = scene::clustered_lights.data[id].position_radius.xyz - position;
    let squared = max(dot(to_light, to_light), 0.0001);
    let intensity = scene::clustered_lights.data[id].color_inverse_square_range;
    let share = squared * intensity.w;
    let kept = saturate(1.0 - share * share);
    return reflected(surface, to_light / sqrt(squared), intensity.rgb * (kept * kept / squared));
}

fn near_light_throws_shadows(id: u32) -> bool {
    return (scene::clustered_lights.data[id].flags & flags::POINT_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) != 0u;
}

// The fraction of a spot light within its cone.
fn cone(position: vec3<f32>, id: u32) -> f32 {
    let data = scene::clustered_lights.data[id].light_custom_data;
    let below = (scene::clustered_lights.data[id].flags & flags::POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE) != 0u;
    let height = sqrt(max(1.0 - data.x * data.x - data.y * data.y, 0.0));
    let axis = vec3<f32>(data.x, select(height, -height, below), data.y);
    let from_light = normalize(position - scene::clustered_lights.data[id].position_radius.xyz);
    let share = saturate(dot(axis, from_light) * data.z + data.w);
    return share * share;
}
