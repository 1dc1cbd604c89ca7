//! Tests of the conversion of options to recipes.

use super::*;
use crate::{Predicted, encode};
use brdfc_codec::range_of;
use brdfc_formats::crop::{DirectionRange, Elevations};
use brdfc_source::open::open;
use brdfc_table::Recipe::{Search, Table};
use brdfc_table::levels::MAX_LEVELS;
use brdfc_table::recipe::{Aim, Size, TableRecipe};
use brdfc_table::search::recipe::Tables;
use brdfc_wavelet::recipe::{Ranking, Recipe};

fn keys(text: &str) -> EncodeOptions {
    toml::from_str(text).unwrap()
}

fn resolved(own: &str, defaults: &str) -> PackRecipe {
    PackRecipe::from_options(&keys(own), &keys(defaults)).unwrap()
}

#[test]
fn the_codec_follows_from_the_options() {
    assert_eq!(resolved("", ""), PackRecipe::default());
    let PackRecipe::Wavelet(paper) = resolved("ratio = 4", "") else { panic!("a wavelet pack") };
    assert_eq!(paper, Recipe { energy_preserving: true, ..Recipe::default() });
    let PackRecipe::Wavelet(named) = resolved("codec = 'wavelet'", "") else { panic!("a wavelet pack") };
    assert_eq!(named, Recipe { energy_preserving: true, ..Recipe::visible() });
    let PackRecipe::Wavelet(plain) = resolved("codec = 'wavelet'\nplain_levels = true", "") else {
        panic!("a wavelet pack")
    };
    assert_eq!(plain, Recipe::visible());
    for wavelet in ["grid = 8", "bits = 12", "parameterisation = 'tangent-pole'", "ranking = 'energy'"] {
        assert!(matches!(resolved(wavelet, ""), PackRecipe::Wavelet(_)), "{wavelet}");
    }
    let PackRecipe::Table(Table(table)) = resolved("codec = 'table'\nmax_bytes = 4096\nbias = 0.001", "") else {
        panic!("a table")
    };
    assert_eq!((table.size, table.bias), (Size::Bytes(4096), 0.001));
    let PackRecipe::Table(Search(tables)) = resolved("codec = 'table'\nmax_delta_e = 0.2", "") else {
        panic!("a search")
    };
    assert!(tables.budget.delta_e == Some(0.2));
    let PackRecipe::Table(Table(factored)) = resolved("codec = 'factored'", "") else { panic!("a table") };
    assert!(factored.factored);
    let PackRecipe::Table(Search(tables)) = resolved("codec = 'factored'\nmax_error = 0.1", "") else {
        panic!("a search")
    };
    assert!(tables.tables == Tables::Factored);
    let PackRecipe::Table(Search(far)) = resolved("levels = 3", "") else { panic!("a search") };
    assert!(far.tables == Tables::Factored && far.table.levels == 3);
    assert_eq!(far.budget, Budget::default());
    for wrong in ["codec = 'table'\nlevels = 2", "codec = 'wavelet'\nlevels = 2", "levels = 7"] {
        assert_eq!(PackRecipe::try_from(keys(wrong)).unwrap_err().field, "levels", "{wrong}");
    }
    let PackRecipe::Table(Search(filled)) = resolved("max_bytes = 4096", "") else { panic!("a search") };
    assert_eq!(filled.budget, Budget::NONE.bytes(4096));
    assert_eq!(filled.table.aim, Aim::Renderings);
    let PackRecipe::Table(Search(even)) = resolved("max_error = 0.1", "") else { panic!("a search") };
    assert_eq!(even.table.aim, Aim::Ratios);
    let PackRecipe::Table(Search(both)) = resolved("max_error = 0.1\nmax_delta_e = 1", "") else { panic!("a search") };
    assert_eq!(both.table.aim, Aim::Renderings);
    let PackRecipe::Table(Search(cheap)) = resolved("max_fetches = 2", "") else { panic!("a search") };
    assert_eq!(cheap.budget.delta_e, Some(0.5), "a limit of fetches is no limit of quality");
}

#[test]
fn defaults_that_do_not_go_with_the_codec_are_left_out() {
    let PackRecipe::Table(Table(table)) = resolved("codec = 'table'", "codec = 'wavelet'\nbias = 0.5\ngrid = 8") else {
        panic!("a table")
    };
    assert_eq!(table, TableRecipe::default());
    let PackRecipe::Wavelet(wavelet) = resolved("codec = 'wavelet'", "max_delta_e = 0.3\nreciprocal = true") else {
        panic!("a wavelet pack")
    };
    assert_eq!(wavelet, Recipe { energy_preserving: true, ..Recipe::visible() });
    // Defaults that a codec does not have are dropped, too. A codec stays if the options go with it.
    assert!(matches!(resolved("codec = 'table'", "levels = 2"), PackRecipe::Table(Table(_))));
    let PackRecipe::Table(Table(levels)) = resolved("levels = 2", "codec = 'factored'\nbias = 0.001") else {
        panic!("a table")
    };
    assert_eq!((levels.levels, levels.factored, levels.bias), (2, true, 0.001));
    let PackRecipe::Table(Table(levels)) = resolved("levels = 2", "codec = 'table'") else { panic!("a table") };
    assert!(levels.factored && levels.levels == 2);
    // A bias without a codec applies to any codec, unless the other defaults select another one.
    let biased = |own: &str, defaults: &str| match resolved(own, defaults) {
        PackRecipe::Table(Search(recipe)) => recipe.table.bias,
        PackRecipe::Table(Table(recipe)) => recipe.bias,
        PackRecipe::Wavelet(recipe) => recipe.bias,
    };
    for own in ["", "codec = 'table'", "codec = 'wavelet'", "ratio = 4", "max_delta_e = 1"] {
        assert_eq!(biased(own, "bias = 0.1"), 0.1, "{own}");
    }
    assert_eq!(biased("max_delta_e = 1", "bias = 0.1\ngrid = 8"), TableRecipe::default().bias);
    assert_eq!(biased("codec = 'wavelet'", "bias = 0.1\nreciprocal = true"), Recipe::visible().bias);
    // Options apply to the codec that the defaults name.
    let PackRecipe::Wavelet(named) = resolved("grid = 8", "codec = 'wavelet'") else { panic!("a wavelet pack") };
    assert_eq!((named.ranking, named.levels), (Ranking::Visible, 3));
    // A ratio that is replaced selects no wavelet pack.
    assert!(matches!(resolved("max_bytes = 4096", "ratio = 4"), PackRecipe::Table(Search(_))));
    assert!(PackRecipe::from_options(&keys("codec = 'table'"), &keys("codec = 'jpeg'")).is_err());
    let PackRecipe::Table(Table(both)) = resolved("reciprocal = true", "codec = 'table'\nbias = 0.001") else {
        panic!("a table")
    };
    assert!(both.reciprocal && both.bias == 0.001);
    // All limits come from the same one of the two.
    let PackRecipe::Table(Search(own)) = resolved("max_delta_e = 0.2", "max_bytes = 4096\nmax_error = '3%'") else {
        panic!("a search")
    };
    assert_eq!(own.budget, Budget::NONE.delta_e(0.2).highlight(0.9));
    assert!(matches!(resolved("ratio = 16", "reciprocal = true\nmax_fetches = 1"), PackRecipe::Wavelet(_)));
    assert!(matches!(resolved("max_delta_e = 0.5", "bias = 0.02\ngrid = 16"), PackRecipe::Table(Search(_))));
    let PackRecipe::Table(Search(theirs)) = resolved("reciprocal = true", "max_bytes = 4096") else {
        panic!("a search")
    };
    assert!(theirs.table.reciprocal && theirs.budget.bytes == Some(4096));
}

#[test]
fn described_ranges_are_the_bounds() {
    assert_eq!(range_of("levels"), format!("0 to {MAX_LEVELS}"));
    let names: Vec<&str> = Choice::all().map(|asked| asked.variant.name).collect();
    assert_eq!(codec_names().replace(" or ", ", "), names.join(", "));
    assert!(names.starts_with(&["auto", "table", "factored"]));
    assert_eq!(range_of("parameterisation"), Recipe::default().parameterisation.name());
    for (name, _) in Ranking::NAMES {
        assert!(range_of("ranking").contains(name), "{name}");
    }
}

/// Options of the command line take precedence over the defaults of a manifest, even if these name another codec.
#[test]
fn options_win_over_defaults_of_other_codecs() {
    for (options, defaults, expected) in [
        ("codec = 'wavelet'", "max_delta_e = 1.0", "codec = 'wavelet'"),
        ("max_delta_e = 1.0", "codec = 'wavelet'", "max_delta_e = 1.0"),
        ("codec = 'table'", "levels = 2", "codec = 'table'"),
        ("ratio = 8", "levels = 2", "ratio = 8"),
        ("codec = 'table'", "codec = 'wavelet'\nratio = 8", "codec = 'table'"),
        ("codec = 'auto'", "grid = 16", "codec = 'auto'"),
        ("grid = 16", "reciprocal = true", "grid = 16"),
        ("max_delta_e = 1.0", "plain_levels = true", "max_delta_e = 1.0"),
        ("", "codec = 'wavelet'\ngrid = 16", "codec = 'wavelet'\ngrid = 16"),
        ("codec = 'jpeg'", "grid = 16", "codec = 'jpeg'\ngrid = 16"),
    ] {
        assert_eq!(options_over(&keys(options), &keys(defaults)), keys(expected), "{options} over {defaults}");
    }
}

/// Every option belongs to a codec, and codecs have no others.
#[test]
fn codecs_have_the_options_that_there_are() {
    let all = keys(
        "max_delta_e = 1\nmin_highlight = 0.5\nmax_error = 0.1\nmax_bytes = 1\nmax_fetches = 1\nreciprocal = true\nlevels = 1\nratio = 4\ngrid = 8\n\
         parameterisation = 'tangent-pole'\nbits = 8\nbias = 0.1\nranking = 'energy'\nplain_levels = true",
    );
    let mut given: Vec<&str> = all.given().collect();
    let mut of_codecs: Vec<&str> = Choice::all().flat_map(|asked| asked.variant.options).copied().collect();
    given.sort_unstable();
    of_codecs.sort_unstable();
    of_codecs.dedup();
    assert_eq!(given, of_codecs);
    assert_eq!(all.only(|_| true), all);
    assert_eq!(all.over(&EncodeOptions::default()), all);
    assert_eq!(all.only(|_| false), EncodeOptions::default());
}

/// Predictions contain the size of the pack.
#[test]
fn packs_are_as_large_as_predicted() {
    let options = |text: &str| PackRecipe::try_from(keys(text));
    let from = |degrees| Elevations { from: degrees, to: 90.0 };
    let seen_from_above = DirectionRange { light: from(30.0), view: from(30.0) };
    let narrow = DirectionRange { light: from(0.0), view: from(85.0) };
    let mut exact = 0;
    for address in ["synth:lambert?kd=0.5", "synth:ggx?kd=0.1,0.2,0.3&f0=0.04&alpha=0.3"] {
        let source = open(address, None).expect("an address").source;
        for text in [
            "",
            "codec = 'table'",
            "max_bytes = 3000",
            "grid = 8\nratio = 4",
            "grid = 32\nratio = 1",
            "grid = 8\nmax_error = '30%'",
        ] {
            for directions in [DirectionRange::ALL, seen_from_above, narrow] {
                let mut recipe = options(text).expect("in range");
                recipe.limit_directions(directions);
                recipe.limit_levels(&|levels| levels - 1);
                let made = encode(source.as_ref(), &recipe, &()).expect("a pack").pack.gpu_bytes();
                let Predicted { least, most } = recipe.predict();
                assert!((least..=most).contains(&made), "{address} {text} {directions}: {least} {made} {most}");
                exact += usize::from(made == least || made == most);
            }
        }
    }
    assert!(exact >= 2, "a ratio fixes the size of a pack");
}
