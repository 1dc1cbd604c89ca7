//! Translated decoders compiled by other tools: glslang, and the validator of SPIR-V. Metal's compiler runs on Apple's
//! systems alone.

use super::texts::{TEXTS, text};
use brdfc_formats::PackKind;
use brdfc_shaders::{Language, shader};
use std::path::Path;
use std::process::Command;

/// Output of a compiler for a file, empty if it accepts the file. `None` if there is no such program.
fn complaint(program: &str, arguments: &[&str], file: &Path) -> Option<String> {
    let output = match Command::new(program).args(arguments).arg(file).output() {
        Ok(output) => output,
        Err(error) => {
            println!("skipped: {program} does not run: {error}");
            return None;
        }
    };
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    Some(if output.status.success() { String::new() } else { said })
}

/// A complete shader around a fragment, as its user would write it, and the arguments of glslang.
fn whole(language: Language, piece: &str) -> Option<(String, &'static [&'static str])> {
    match language {
        Language::Glsl => Some((
            format!("#version 330\n{piece}\nout vec4 colour;\nvoid main() {{ colour = vec4(1.0); }}\n"),
            &["-S", "frag"],
        )),
        Language::Essl300 => Some((
            format!("#version 300 es\n{piece}\nout highp vec4 colour;\nvoid main() {{ colour = vec4(1.0); }}\n"),
            &["-S", "frag"],
        )),
        Language::Hlsl => Some((
            format!("{piece}\nfloat4 main() : SV_Target {{ return (1.0).xxxx; }}\n"),
            &["-D", "-V", "-S", "frag", "-e", "main"],
        )),
        Language::Wgsl | Language::Msl | Language::Spirv => None,
    }
}

#[test]
fn glslang_compiles_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shader.txt");
    // glslang writes SPIR-V into the working directory.
    let out = folder.path().join("out.spv").display().to_string();
    let mut compiled = 0;
    for decoder in PackKind::ALL {
        for language in TEXTS {
            let piece = text(decoder, language);
            let Some((source, arguments)) = whole(language, &piece) else { continue };
            let arguments: Vec<&str> =
                if arguments.contains(&"-V") { [arguments, &["-o", &out]].concat() } else { arguments.to_vec() };
            std::fs::write(&file, &source).unwrap();
            let Some(said) = complaint("glslangValidator", &arguments, &file) else { return };
            assert_eq!(said, "", "{} in {}", decoder.name(), language.name());
            // The control: a wrong type is an error.
            std::fs::write(&file, source + "flaot x;\n").unwrap();
            assert!(complaint("glslangValidator", &arguments, &file).unwrap().contains("ERROR"));
            compiled += 1;
        }
    }
    assert_eq!(compiled, 3 * PackKind::ALL.len());
}

#[test]
fn the_validator_of_spirv_accepts_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shader.spv");
    for decoder in PackKind::ALL {
        let words = shader(decoder, Language::Spirv).bytes;
        std::fs::write(&file, &words).unwrap();
        let Some(said) = complaint("spirv-val", &["--target-env", "vulkan1.1"], &file) else { return };
        assert_eq!(said, "", "{}", decoder.name());
        // The control: without its last instruction the module is invalid.
        std::fs::write(&file, &words[..words.len() - 4]).unwrap();
        assert_ne!(complaint("spirv-val", &["--target-env", "vulkan1.1"], &file).unwrap(), "");
    }
}
