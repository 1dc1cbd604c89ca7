//! The WGSL of bandwidth propagation and of importance samples without a graphics adapter.

use brdfc_formats::bandwidth::propagation::PROPAGATION_WGSL;
use brdfc_formats::importance::{IMPORTANCE_WGSL, ImportanceHeader};
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Error of naga for a shader, with no capabilities beyond WebGPU without features.
fn complaint(text: &str) -> Option<String> {
    let module = match naga::front::wgsl::parse_str(text) {
        Ok(module) => module,
        Err(error) => return Some(error.emit_to_string(text)),
    };
    let result = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    result.err().map(|error| error.emit_to_string(text))
}

#[test]
fn they_validate() {
    assert_eq!(complaint(PROPAGATION_WGSL), None);
    assert_eq!(complaint(IMPORTANCE_WGSL), None);
    for (source, from, to) in [
        (PROPAGATION_WGSL, "var ray = ", "let ray = "),
        (IMPORTANCE_WGSL, "var half_vector = texel.xyz", "var half_vector = texel"),
    ] {
        let bad = source.replace(from, to);
        assert!(bad != source && complaint(&bad).is_some(), "{to}");
    }
}

#[test]
fn the_uniform_block_is_the_one_that_rust_writes() {
    let module = naga::front::wgsl::parse_str(IMPORTANCE_WGSL).unwrap();
    let find = |ty: &naga::Type| ty.name.as_deref() == Some("ImportanceParameters");
    let (_, block) = module.types.iter().find(|(_, ty)| find(ty)).unwrap();
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, ImportanceHeader::UNIFORM_SIZE);
    let bytes = ImportanceHeader { polar: 5, azimuths: 8, samples: 7 }.uniform();
    let words = [("polar", 5), ("azimuths", 8), ("samples", 7), ("reserved", 0)];
    assert_eq!(members.len(), words.len());
    for (member, (name, expected)) in members.iter().zip(words) {
        assert_eq!(member.name.as_deref(), Some(name));
        assert_eq!(u32::from_le_bytes(bytes[member.offset as usize..][..4].try_into().unwrap()), expected);
    }
}
