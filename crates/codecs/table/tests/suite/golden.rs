//! Encodings of committed inputs have the bytes, and decode to the values, in the codec's list: see docs/goldens.md.

use brdfc_source::open::open;
use brdfc_table::encode::encode;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_testing::codecs::table::tables;
use brdfc_testing::golden::encodes::{Packs, check_encodes};
use brdfc_testing::testdata;

#[test]
fn table_packs() {
    let made = |input: &str, recipe: TableRecipe| {
        let source = open(input, None).unwrap_or_else(|error| panic!("{error}")).source;
        encode(source.as_ref(), &recipe, &()).unwrap_or_else(|error| panic!("{error}")).bytes
    };
    let pack = |input: &str, bytes: u64, reciprocal: bool| {
        made(input, TableRecipe { size: Size::Bytes(bytes), reciprocal, ..TableRecipe::default() })
    };
    let factored = |input: &str, bytes: u64| {
        made(input, TableRecipe { size: Size::Bytes(bytes), factored: true, ..TableRecipe::default() })
    };
    let levelled = |input: &str, bytes: u64| {
        made(input, TableRecipe { size: Size::Bytes(bytes), levels: 4, ..TableRecipe::default() })
    };
    let mut packs = Packs::from([
        ("isotropic-rgb.ktx2".to_owned(), pack(&testdata("demo/red_plastic.binary"), 4096, false)),
        ("isotropic-grey.ktx2".to_owned(), pack("synth:ggx?alpha=0.3", 2048, false)),
        ("anisotropic-grey.ktx2".to_owned(), pack("synth:ward?ax=0.15&ay=0.5", 4096, false)),
        ("anisotropic-rgb.ktx2".to_owned(), pack("synth:velvet?kd=0.1,0.2,0.4", 4096, false)),
        ("reciprocal.ktx2".to_owned(), pack("synth:lewis?kd=0.3,0.1,0.05&ks=0.5&n=15", 2048, true)),
        ("factored-rgb.ktx2".to_owned(), factored("synth:ggx?kd=0.3,0.1,0.05&alpha=0.05", 4096)),
        ("levels-rgb.ktx2".to_owned(), levelled("synth:ggx?kd=0.3,0.1,0.05&alpha=0.05", 4096)),
        ("factored-grey.ktx2".to_owned(), factored("synth:ward?ax=0.15&ay=0.5", 4096)),
    ]);
    // Every symmetry, of made-up texels.
    packs.extend(tables().into_iter().map(|(name, pack)| {
        let file = format!("any-texels-{}.ktx2", name.replace(", ", "-").replace(' ', "-"));
        (file, pack.to_bytes(false))
    }));
    check_encodes("table", &packs, |_| true);
}
