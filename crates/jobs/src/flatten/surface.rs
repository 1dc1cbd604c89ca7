//! Summaries of the inputs of flattening.

use super::describe::{MeshFacts, SurfaceFacts};
use super::words::{height, repairs_summary};
use brdfc_core::words::bytes;

/// Names and values of the properties of an input.
pub fn summary(facts: &SurfaceFacts) -> Vec<(&'static str, String)> {
    match facts {
        SurfaceFacts::Structure { address, vertices, triangles, heights: [low, high], materials } => vec![
            ("kind", "structure, for 'brdfc flatten'".to_owned()),
            ("address", address.clone()),
            ("mesh of a tile", format!("{vertices} vertices, {triangles} triangles")),
            ("heights", format!("{} to {} tiles", height(*low), height(*high))),
            ("materials", materials.join(", ")),
        ],
        SurfaceFacts::Mesh(mesh) => mesh_summary(mesh),
        SurfaceFacts::HeightMap { size: [width, height], values: [low, high], conversions } => vec![
            ("kind", "height map, for 'brdfc flatten'".to_owned()),
            ("pixels", format!("{width} x {height}")),
            ("values", format!("{low} to {high}, times --height-scale in tiles")),
            ("pixel values", conversions.join("; ")),
        ],
        SurfaceFacts::UboBtf {
            views,
            lights,
            size: [width, height],
            colour_model,
            components,
            has_cosine,
            devices,
            memory_bytes,
        } => vec![
            ("kind", "an ordinary BTF of the Bonn database of 2014, for 'brdfc flatten'".to_owned()),
            ("views x lights", format!("{views} x {lights}")),
            ("texels", format!("{width} x {height}")),
            ("colour model", colour_model.to_string()),
            ("components", components.iter().map(usize::to_string).collect::<Vec<_>>().join(" + ")),
            ("cosine", if *has_cosine { "in the values" } else { "not in the values" }.to_owned()),
            ("measured by", if devices.is_empty() { "unknown".to_owned() } else { devices.join(", ") }),
            ("in memory", bytes(*memory_bytes)),
        ],
        SurfaceFacts::ImageStack {
            views,
            lights,
            images,
            missing,
            size: [width, height],
            colour,
            notes,
            extensions,
        } => vec![
            ("kind", "images of an ordinary BTF, for 'brdfc flatten'".to_owned()),
            ("views x lights", format!("{views} x {lights}")),
            ("images", format!("{images}, .{}", extensions.join(", ."))),
            (
                "missing",
                if *missing == 0 { "none".to_owned() } else { format!("{missing}; 'brdfc flatten' requires all") },
            ),
            ("pixels", format!("{width} x {height}")),
            ("colour", [std::slice::from_ref(colour), notes].concat().join("; ")),
        ],
    }
}

fn mesh_summary(mesh: &MeshFacts) -> Vec<(&'static str, String)> {
    let [x, y, z] = mesh.bounds.map(|[low, high]| format!("{low} to {high}"));
    let materials = if mesh.materials.is_empty() { "no names".to_owned() } else { mesh.materials.join(", ") };
    let mut lines = vec![
        ("kind", "mesh, for 'brdfc flatten'".to_owned()),
        ("vertices", format!("{}{}", mesh.vertices, if mesh.colours { ", with colours" } else { "" })),
        ("triangles", mesh.triangles.to_string()),
        ("materials", materials),
        ("bounding box", format!("x {x}, y {y}")),
        ("heights", z),
    ];
    match (mesh.tile, &mesh.problem) {
        (Some(tile), _) => lines.push(("closes", format!("with --tile {tile}"))),
        (None, Some(problem)) => lines.push(("does not close", problem.clone())),
        (None, None) => {}
    }
    if let Some(repairs) = &mesh.repairs {
        lines.push(("surface", format!("{} vertices, {} triangles", repairs.vertices, repairs.triangles)));
        let text = repairs_summary(repairs);
        lines.push(("repaired", if text.is_empty() { "nothing".to_owned() } else { text.join("; ") }));
    }
    lines
}
