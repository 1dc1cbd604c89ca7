//! Device features and limits that textures require.

use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_shaders::DeviceNeeds;

#[test]
fn ordinary_textures_have_no_requirements() {
    let extents =
        [Extent::D2([2048; 2]), Extent::D2Array([256, 256, 256]), Extent::D3([64, 64, 256]), Extent::Cube(2048)];
    for extent in extents {
        let needs = DeviceNeeds::of(TexelFormat::Rgba8Unorm, extent);
        assert_eq!((needs.summary().as_str(), needs), ("any with WebGPU or WebGL 2", DeviceNeeds::default()));
    }
}

#[test]
fn requirements_beyond_the_limits_are_reported() {
    let deep = DeviceNeeds::of(TexelFormat::Rgba16Unorm, Extent::D3([64, 64, 1024]));
    assert_eq!(
        deep.summary(),
        "texture-formats-tier1 of WebGPU, EXT_texture_norm16 of WebGL 2, or texels unpacked to 32-bit floats; \
         more than WebGL 2 guarantees: 1024 texels along a side in 3D (limit 256)"
    );
    let many = DeviceNeeds::of(TexelFormat::R8Unorm, Extent::D2Array([16, 16, 300]));
    assert_eq!(many.summary(), "more than WebGPU's default limits: 300 layers (limit 256)");
    let both = many.clone().with(deep.clone()).with(many.clone());
    assert_eq!((both.webgpu_features.len(), both.beyond_webgpu.len(), both.beyond_webgl_2.len()), (1, 1, 2));
}
