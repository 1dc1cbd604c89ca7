//! Addresses of analytic models.
//!
//! ```text
//! address   = "synth:" model
//! model     = name [ "?" parameter *( "&" parameter ) ]
//! parameter = name "=" number [ "," number "," number ]
//! number    = a decimal number, such as 0.3, 20 or 1.5e-2
//! ```
//!
//! Names are listed in [`MODELS`], in lower case, without spaces or escapes. A colour is one number for all channels,
//! or three: linear red, green and blue. Parameters may come in any order, each at most once; omitted ones have their
//! defaults. A shorthand (`alpha` of `ggx`) sets several parameters and counts as each of them. On most command lines
//! an address needs quotes: `"synth:lewis?kd=0.6&n=20"`.

use super::Source;
use super::analytic::{Analytic, MODELS, Parameter, ParameterKind, Shorthand};
use super::words::{one_of, quoted};
use std::fmt::Write;

/// Prefix of the addresses of analytic models.
pub const SYNTH_PREFIX: &str = "synth:";

/// Error of an invalid address of an analytic model.
///
/// Reads as `n of lewis: found -1, expected 0 to 10000`, or as `n of lewis: repeated; expected one value`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{part}: {}{}", reason(.found.as_deref(), .allowed), did_you_mean(.suggestion))]
pub struct AddressError {
    /// Part of the address.
    pub part: String,
    /// Text of the part; `None` if the address has several values of it.
    pub found: Option<String>,
    /// Text or values that are valid for the part.
    pub allowed: String,
    /// Valid name closest to the text of the part, if any is close.
    pub suggestion: Option<String>,
}

fn reason(found: Option<&str>, allowed: &str) -> String {
    match found {
        Some(found) => format!("found {found}, expected {allowed}"),
        None => format!("repeated; expected {allowed}"),
    }
}

fn did_you_mean(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map(|name| format!("; did you mean {name}?")).unwrap_or_default()
}

impl AddressError {
    fn new(part: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self { part: part.into(), found: Some(found.into()), allowed: allowed.into(), suggestion: None }
    }

    fn repeated(part: impl Into<String>) -> Self {
        Self { part: part.into(), found: None, allowed: "one value".to_owned(), suggestion: None }
    }

    fn unknown_name(part: impl Into<String>, found: &str, allowed: &[&str]) -> Self {
        // A single valid name needs no suggestion.
        let suggestion = nearest(found, allowed).filter(|_| allowed.len() > 1).map(str::to_owned);
        Self { suggestion, ..Self::new(part, quoted(found), one_of(allowed)) }
    }
}

/// Returns true if an input is the address of an analytic model, not a path.
pub fn is_synth(input: &str) -> bool {
    input.starts_with(SYNTH_PREFIX)
}

/// Parses the address of a model, `synth:MODEL?param=value&...`; see the module for the grammar.
///
/// # Errors
///
/// Returns an error if the prefix is missing, the model or a parameter is unknown, or a value is missing, repeated, not
/// a number, or out of range.
pub fn parse_synth(address: &str) -> Result<Box<dyn Source>, AddressError> {
    let model = address
        .strip_prefix(SYNTH_PREFIX)
        .ok_or_else(|| AddressError::new("address", quoted(address), format!("{SYNTH_PREFIX}MODEL?param=value&...")))?;
    Ok(parse_model(model)?)
}

/// Parses the address of a model without its prefix, `MODEL?param=value&...`.
///
/// # Errors
///
/// Returns an error if the model or a parameter is unknown, or a value is missing, repeated, not a number, or out of
/// range.
pub fn parse_model(text: &str) -> Result<Box<dyn Analytic>, AddressError> {
    let (name, query) = split_query(text);
    let info = find_named("model", name, &MODELS, |m| m.name)?;
    let values = parse_parameters(info.name, info.parameters, info.shorthands, query)?;
    Ok((info.build)(&values))
}

/// Splits an address without its prefix into the name and the parameters after `?`, if any.
pub fn split_query(text: &str) -> (&str, Option<&str>) {
    text.split_once('?').map_or((text, None), |(name, query)| (name, Some(query)))
}

/// Finds an item by name; `part` names the kind of items in errors.
///
/// # Errors
///
/// Returns an error if no item has the name.
pub fn find_named<T: Copy>(
    part: &str,
    name: &str,
    items: &[T],
    name_of: impl Fn(T) -> &'static str,
) -> Result<T, AddressError> {
    let names: Vec<&str> = items.iter().map(|item| name_of(*item)).collect();
    let found = names.iter().position(|known| *known == name);
    found.map(|k| items[k]).ok_or_else(|| AddressError::unknown_name(part, name, &names))
}

/// Parses the part of an address after `?` into the values of `parameters`, in their order. Omitted parameters have
/// their defaults, and a number fills all three channels. `owner` is the name in errors.
///
/// # Errors
///
/// Returns an error if a parameter is unknown, or a value is missing, repeated, not a number, or out of range.
pub fn parse_parameters(
    owner: &str,
    parameters: &[Parameter],
    shorthands: &[Shorthand],
    query: Option<&str>,
) -> Result<Vec<[f64; 3]>, AddressError> {
    let mut values = vec![None; parameters.len()];
    for item in query.into_iter().flat_map(|q| q.split('&')) {
        set(owner, parameters, shorthands, item, &mut values)?;
    }
    Ok(parameters.iter().zip(values).map(|(p, value)| value.unwrap_or([p.default; 3])).collect())
}

/// Address of a model with every parameter, in the model's order, each number in its shortest exact form.
///
/// Models with the same values have the same canonical address, which parses to the same values.
pub fn canonical(model: &dyn Analytic) -> String {
    let info = model.info();
    canonical_address(info.name, info.parameters, &model.values())
}

/// Canonical address of any name with parameters, in the form of [`canonical`].
pub fn canonical_address(name: &str, parameters: &[Parameter], values: &[[f64; 3]]) -> String {
    let mut text = format!("{SYNTH_PREFIX}{name}");
    for (k, (parameter, value)) in parameters.iter().zip(values).enumerate() {
        // Adding zero turns -0 into 0.
        let [r, g, b] = value.map(|v| v + 0.0);
        let separator = if k == 0 { '?' } else { '&' };
        let _ = write!(text, "{separator}{}={r}", parameter.name);
        if parameter.kind == ParameterKind::Colour && (g != r || b != r) {
            let _ = write!(text, ",{g},{b}");
        }
    }
    text
}

/// Lists all models with their parameters, ranges and defaults, for help texts.
pub fn describe_models() -> String {
    MODELS.iter().map(|info| describe(info.name, info.meaning, info.parameters, info.shorthands)).collect()
}

/// Describes a name of addresses with its parameters, ranges and defaults, for help texts.
pub fn describe(name: &str, meaning: &str, parameters: &[Parameter], shorthands: &[Shorthand]) -> String {
    let names = parameters.iter().map(|p| p.name).chain(shorthands.iter().map(|s| s.name));
    let width = names.map(str::len).fold(9, usize::max);
    let mut text = format!("{name:<9} {meaning}\n");
    for p in parameters {
        let kind = match p.kind {
            ParameterKind::Number => "",
            ParameterKind::Integer => ", whole",
            ParameterKind::Colour => " or r,g,b",
        };
        let (range, default) = (format!("{} to {}{kind}", p.minimum, p.maximum), p.default);
        let _ = writeln!(text, "  {:<width$} {range:<18} default {default:<5} {}", p.name, p.meaning);
    }
    for s in shorthands {
        let _ = writeln!(text, "  {:<width$} sets {}", s.name, s.stands_for.join(" and "));
    }
    text
}

fn set(
    owner: &str,
    parameters: &[Parameter],
    shorthands: &[Shorthand],
    item: &str,
    values: &mut [Option<[f64; 3]>],
) -> Result<(), AddressError> {
    let of_owner = |what: &str| format!("{what} of {owner}");
    let Some((name, value)) = item.split_once('=') else {
        return Err(AddressError::new(of_owner("parameter"), quoted(item), "name=value"));
    };
    let shorthand = shorthands.iter().find(|s| s.name == name);
    let mut known = false;
    for (k, parameter) in parameters.iter().enumerate() {
        if parameter.name != name && !shorthand.is_some_and(|s| s.stands_for.contains(&parameter.name)) {
            continue;
        }
        known = true;
        if values[k].is_some() {
            return Err(AddressError::repeated(of_owner(parameter.name)));
        }
        values[k] = Some(parse_value(parameter, value, &of_owner(name))?);
    }
    if known {
        return Ok(());
    }
    let allowed: Vec<&str> = parameters.iter().map(|p| p.name).chain(shorthands.iter().map(|s| s.name)).collect();
    Err(AddressError::unknown_name(of_owner("parameter"), name, &allowed))
}

fn parse_value(parameter: &Parameter, text: &str, part: &str) -> Result<[f64; 3], AddressError> {
    let (minimum, maximum) = (parameter.minimum, parameter.maximum);
    let numbers: Vec<&str> = text.split(',').collect();
    let allowed_counts: &[usize] = if parameter.kind == ParameterKind::Colour { &[1, 3] } else { &[1] };
    if !allowed_counts.contains(&numbers.len()) {
        let allowed = if allowed_counts.len() > 1 { "one number, or three with commas" } else { "one number" };
        return Err(AddressError::new(part, quoted(text), allowed));
    }
    let whole = parameter.kind == ParameterKind::Integer;
    let range = if whole { "a whole number, " } else { "" };
    let mut value = [0.0; 3];
    for (c, slot) in value.iter_mut().enumerate() {
        let number = numbers[c.min(numbers.len() - 1)];
        *slot = number
            .parse()
            .ok()
            .filter(|v| (minimum..=maximum).contains(v) && !(whole && f64::fract(*v) != 0.0))
            .ok_or_else(|| AddressError::new(part, quoted(number), format!("{range}{minimum} to {maximum}")))?;
    }
    Ok(value)
}

fn nearest<'a>(found: &str, allowed: &[&'a str]) -> Option<&'a str> {
    let found = found.to_lowercase();
    let near = |name: &&str| {
        let distance = strsim::damerau_levenshtein(&found, name);
        let longest = found.chars().count().max(name.len());
        // Requires one common letter, and allows one wrong letter in three.
        (distance < longest && distance <= longest.div_ceil(3)).then_some(distance)
    };
    allowed.iter().filter_map(|name| near(name).map(|d| (d, *name))).min_by_key(|&(d, _)| d).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(text: &str) -> String {
        parse_model(text).err().map(|e| e.to_string()).unwrap_or_default()
    }

    fn canonical_of(text: &str) -> String {
        canonical(parse_model(text).unwrap().as_ref())
    }

    #[test]
    fn defaults_fill_omitted_parameters() {
        assert_eq!(canonical_of("lambert"), "synth:lambert?kd=0.5");
        assert_eq!(canonical_of("lewis?n=5e1"), "synth:lewis?kd=0.6&ks=0.3&n=50");
        assert_eq!(canonical_of("ward?ay=0.25&kd=0.6,0.1,.1"), "synth:ward?kd=0.6,0.1,0.1&ks=0.1&ax=0.15&ay=0.25");
        assert_eq!(canonical_of("poulin?h=-0&kd=0.1,0.1,0.1"), "synth:poulin?kd=0.1&ks=0.1&d=2.5&h=0&n=20");
        assert_eq!(canonical_of("ggx?alpha=0.1"), "synth:ggx?kd=0.2&f0=0.04&alpha_x=0.1&alpha_y=0.1");
    }

    #[test]
    fn addresses_become_sources() {
        assert!(is_synth("synth:lambert") && !is_synth("lambert.binary"));
        assert!(parse_synth("synth:lambert").unwrap().is_grey());
        assert!(!parse_synth("synth:lambert?kd=0.1,0.2,0.3").unwrap().is_grey());
        let missing = parse_synth("lambert").err().unwrap().to_string();
        assert_eq!(missing, "address: found \"lambert\", expected synth:MODEL?param=value&...");
    }

    #[test]
    fn errors_name_the_part_and_valid_values() {
        for (text, expected) in [
            ("", "model: found \"\", expected lambert, lewis, ward, poulin, ggx or velvet"),
            (
                "Lambrt",
                "model: found \"Lambrt\", expected lambert, lewis, ward, poulin, ggx or velvet; did you mean lambert?",
            ),
            ("phong", "model: found \"phong\", expected lambert, lewis, ward, poulin, ggx or velvet"),
            ("lambert?", "parameter of lambert: found \"\", expected name=value"),
            ("lambert?kd=0.1&", "parameter of lambert: found \"\", expected name=value"),
            ("lambert?kd", "parameter of lambert: found \"kd\", expected name=value"),
            ("lambert?q=1", "parameter of lambert: found \"q\", expected kd"),
            (
                "ggx?alfa=1",
                "parameter of ggx: found \"alfa\", expected kd, f0, alpha_x, alpha_y or alpha; did you mean alpha?",
            ),
            ("lambert?kd=", "kd of lambert: found \"\", expected 0 to 1"),
            ("lambert?kd=NaN", "kd of lambert: found NaN, expected 0 to 1"),
            ("lambert?kd=0.1, 0.2,0.3", "kd of lambert: found \" 0.2\", expected 0 to 1"),
            ("lambert?kd=0.1,0.2", "kd of lambert: found 0.1,0.2, expected one number, or three with commas"),
            ("lambert?kd=0.1&kd=0.1", "kd of lambert: repeated; expected one value"),
            ("lewis?n=inf", "n of lewis: found inf, expected 0 to 10000"),
            ("lewis?n=1,2,3", "n of lewis: found 1,2,3, expected one number"),
            ("poulin?d=1.9", "d of poulin: found 1.9, expected 2 to 100"),
            ("ggx?alpha_x=0.1&alpha=0.2", "alpha_x of ggx: repeated; expected one value"),
            ("ggx?alpha=2", "alpha of ggx: found 2, expected 0.001 to 1"),
            ("lambert?kd=\u{1b}[2J", "kd of lambert: found \"\\u{1b}[2J\", expected 0 to 1"),
        ] {
            assert_eq!(error(text), expected);
        }
    }

    #[test]
    fn the_specification_lists_every_parameter() {
        let page = include_str!("../../../docs/synth.md");
        for info in MODELS {
            assert!(page.contains(&format!("## {}\n", info.name)), "{}", info.name);
            for p in info.parameters {
                let kind = if p.kind == ParameterKind::Colour { "colour" } else { "number" };
                let row = format!("| {} | {kind} | {} to {} | {} |", p.name, p.minimum, p.maximum, p.default);
                let section = page.split("\n## ").find(|s| s.starts_with(info.name)).unwrap();
                assert!(section.contains(&row), "{}: {row}", info.name);
                assert!((p.minimum..=p.maximum).contains(&p.default));
            }
        }
        let help = describe_models();
        assert!(help.contains("lewis ") && help.contains("alpha     sets alpha_x and alpha_y"), "{help}");
    }

    proptest! {
        #[test]
        fn any_text_is_parsed_or_rejected(text in "(lambert|lewis|ward|poulin|ggx|velvet|x)?\\??[a-z=&,.0-9_-]{0,30}") {
            if let Ok(model) = parse_model(&text) {
                let address = canonical(model.as_ref());
                let again = parse_model(&address[SYNTH_PREFIX.len()..]).unwrap();
                prop_assert_eq!(again.values(), model.values());
                prop_assert_eq!(canonical(again.as_ref()), address);
            }
        }

        #[test]
        fn canonical_addresses_round_trip(
            model in 0usize..5,
            shares in prop::collection::vec([0.0f64..=1.0, 0.0f64..=1.0, 0.0f64..=1.0], 5),
        ) {
            let info = MODELS[model];
            let value = |p: &Parameter, shares: [f64; 3]| {
                let value = shares.map(|t| (p.minimum + t * (p.maximum - p.minimum)).min(p.maximum));
                if p.kind == ParameterKind::Colour { value } else { [value[0]; 3] }
            };
            let values: Vec<[f64; 3]> = info.parameters.iter().zip(shares).map(|(p, t)| value(p, t)).collect();
            let address = canonical((info.build)(&values).as_ref());
            prop_assert_eq!(parse_model(&address[SYNTH_PREFIX.len()..]).unwrap().values(), values);
        }
    }
}
