//! Direction sets against the list of a measured database.

use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::direction_list;

#[test]
fn the_set_of_2014_is_that_of_the_database() {
    let Some(file) = brdfc_testing::shared_data("ubo2014_151_directions.csv") else { return };
    let measured = direction_list::from_csv(&std::fs::read(file).unwrap()).unwrap();
    assert_eq!(DirectionSet::ubo2014().angles, measured.angles);
    assert_ne!(DirectionSet::ubo2003().angles, measured.angles);
}
