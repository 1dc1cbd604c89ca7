//! A contact sheet: small renderings of many materials with labels, and the colour scale of their differences.

use crate::rendering::{DELTA_E_FULL_SCALE, Panel, heat_map};
use embedded_graphics::Drawable;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{
    MonoFont, MonoTextStyle, iso_8859_1, iso_8859_2, iso_8859_5, iso_8859_7, iso_8859_9, iso_8859_13,
};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Baseline, Text};
use std::convert::Infallible;

/// Headings of the columns of a cell.
pub const HEADS: [&str; 3] = ["source", "pack", "ΔE"];

/// Margin around the sheet and between cells, pixels.
const MARGIN: usize = 14;
/// Gap between the renderings of a cell, pixels.
const GAP: usize = 2;
/// One font for each script: Latin with the Δ, Greek; Western, Central European, Turkish and Baltic Latin; Cyrillic.
type Fonts = [&'static MonoFont<'static>; 6];
const PLAIN: Fonts = [
    &iso_8859_7::FONT_7X13,
    &iso_8859_1::FONT_7X13,
    &iso_8859_2::FONT_7X13,
    &iso_8859_9::FONT_7X13,
    &iso_8859_13::FONT_7X13,
    &iso_8859_5::FONT_7X13,
];
const BOLD: Fonts = [
    &iso_8859_7::FONT_7X13_BOLD,
    &iso_8859_1::FONT_7X13_BOLD,
    &iso_8859_2::FONT_7X13_BOLD,
    &iso_8859_9::FONT_7X13_BOLD,
    &iso_8859_13::FONT_7X13_BOLD,
    &iso_8859_5::FONT_7X13_BOLD,
];
/// Height of a line of text, pixels.
const LINE: usize = 16;
/// Width of a letter, pixels.
const LETTER: usize = 7;
/// Replacement for the middle of a name that is too long.
const ELLIPSIS: &str = "...";
/// Width and height of the bar of the colour scale, pixels.
const BAR: [usize; 2] = [200, 12];
/// Ticks of the scale, except at 0.
const TICKS: usize = 5;
/// Space on each side of the bar, for the first and the last number, pixels.
const BAR_MARGIN: usize = 3 * LETTER;
/// Aspect ratio, width by height, that sheets of many cells approximate.
const ASPECT: f64 = 4.0 / 3.0;
const PAPER: u8 = 250;
const INK: Rgb888 = Rgb888::new(28, 30, 33);
const SOFT: Rgb888 = Rgb888::new(95, 98, 103);
const BAD: Rgb888 = Rgb888::new(179, 38, 30);

/// One material of a sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// Its name, shortened in the middle if it is too long.
    pub name: String,
    /// Text below the name: bytes, errors.
    pub details: String,
    /// True if the material failed; `details` are then highlighted.
    pub failed: bool,
    /// One row per scene of source, pack and their difference. Missing panels stay blank.
    pub rows: Vec<[Option<Panel>; 3]>,
}

/// Draws the cells left to right and down, above the colour scale, in as many columns as make the sheet about 4:3. The
/// same cells give the same bytes.
pub fn contact_sheet(cells: &[Cell]) -> Panel {
    let grid = Grid::of(cells);
    let [width, height] = grid.size();
    let mut canvas = Canvas(Panel { width, height, rgb: vec![PAPER; 3 * width * height] });
    for column in 0..grid.columns {
        for (number, head) in HEADS.into_iter().enumerate() {
            let x = grid.left(column) + grid.across(number) + grid.rendering[0] / 2;
            canvas.centred(head, [x, MARGIN]);
        }
    }
    for (number, cell) in cells.iter().enumerate() {
        let left = grid.left(number % grid.columns);
        let mut top = grid.top(number / grid.columns);
        for row in &cell.rows {
            for (across, panel) in row.iter().enumerate() {
                if let Some(panel) = panel {
                    canvas.paste(panel, [left + grid.across(across), top]);
                }
            }
            top += grid.rendering[1] + GAP;
        }
        let text = grid.top(number / grid.columns) + grid.rows * (grid.rendering[1] + GAP);
        let letters = grid.cell[0] / LETTER;
        canvas.text(&shortened(&spelled(&cell.name), letters), [left, text], &BOLD, INK);
        let colour = if cell.failed { BAD } else { SOFT };
        canvas.text(&shortened(&spelled(&cell.details), letters), [left, text + LINE], &PLAIN, colour);
    }
    scale(&mut canvas, [MARGIN + BAR_MARGIN, height - MARGIN - BAR[1] - LINE]);
    canvas.0
}

/// Layout of the cells.
struct Grid {
    /// Columns of cells in the sheet.
    columns: usize,
    /// Rows of cells in the sheet.
    lines: usize,
    /// Rows of renderings in a cell.
    rows: usize,
    /// Width and height of the largest rendering, pixels.
    rendering: [usize; 2],
    /// Width and height of a cell with its text, pixels.
    cell: [usize; 2],
}

impl Grid {
    fn of(cells: &[Cell]) -> Self {
        let renderings = || cells.iter().flat_map(|cell| cell.rows.iter().flatten().flatten());
        // Wide enough for the column headings.
        let width = renderings().map(|panel| panel.width).max().unwrap_or(0).max(8 * LETTER);
        let height = renderings().map(|panel| panel.height).max().unwrap_or(0);
        let rows = cells.iter().map(|cell| cell.rows.len()).max().unwrap_or(0);
        let cell = [HEADS.len() * (width + GAP) - GAP, rows * (height + GAP) + 2 * LINE];
        let with = |columns: usize| {
            let lines = cells.len().div_ceil(columns).max(1);
            Self { columns, lines, rows, rendering: [width, height], cell }
        };
        let off = |grid: &Self| {
            let [width, height] = grid.size();
            (width as f64 / height as f64 / ASPECT).ln().abs()
        };
        (1..=cells.len()).map(with).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_else(|| with(1))
    }

    fn size(&self) -> [usize; 2] {
        let narrowest = 2 * MARGIN + BAR[0] + 2 * BAR_MARGIN;
        let width = (MARGIN + self.columns * (self.cell[0] + MARGIN)).max(narrowest);
        [width, self.top(self.lines) + BAR[1] + LINE + MARGIN]
    }

    fn left(&self, column: usize) -> usize {
        MARGIN + column * (self.cell[0] + MARGIN)
    }

    fn top(&self, line: usize) -> usize {
        MARGIN + LINE + line * (self.cell[1] + MARGIN)
    }

    /// Offset from the left of a cell to its rendering with this number.
    fn across(&self, number: usize) -> usize {
        number * (self.rendering[0] + GAP)
    }
}

/// Draws the colour scale of differences with numbers below. The upper left corner of its bar is at `left`, `top`.
fn scale(canvas: &mut Canvas, [left, top]: [usize; 2]) {
    let [width, height] = BAR;
    let shares: Vec<f32> = (0..width).map(|x| x as f32 / (width - 1) as f32).collect();
    let row = heat_map(&shares, width, 1, 1.0).rgb;
    canvas.paste(&Panel { width, height, rgb: row.repeat(height) }, [left, top]);
    canvas.text("ΔE", [left + 1 - 3 * LETTER, top], &PLAIN, SOFT);
    for tick in 0..=TICKS {
        let x = left + tick * (width - 1) / TICKS;
        canvas.paste(&Panel { width: 1, height: 3, rgb: [INK.r(), INK.g(), INK.b()].repeat(3) }, [x, top + height]);
        let value = DELTA_E_FULL_SCALE * tick as f64 / TICKS as f64;
        canvas.centred(&value.to_string(), [x, top + height + 3]);
    }
}

/// The first font that has a letter.
fn font_of(letter: char, fonts: &Fonts) -> Option<&'static MonoFont<'static>> {
    // Fonts draw a "?" for letters that they lack.
    let has = |font: &&MonoFont<'_>| {
        letter == '?' || font.glyph_mapping.index(letter) != font.glyph_mapping.index(char::REPLACEMENT_CHARACTER)
    };
    fonts.iter().copied().find(has)
}

/// Replaces letters that no font has by code points, such as `U+6F22`, so that names stay distinct.
fn spelled(text: &str) -> String {
    let letter = |letter: char| match font_of(letter, &PLAIN) {
        Some(_) => letter.to_string(),
        None => format!("U+{:04X}", u32::from(letter)),
    };
    text.chars().map(letter).collect()
}

/// Shortens a text of more than `most` letters in the middle.
fn shortened(text: &str, most: usize) -> String {
    let letters: Vec<char> = text.chars().collect();
    if letters.len() <= most {
        return text.to_owned();
    }
    let retained = most.saturating_sub(ELLIPSIS.len());
    let (first, last) = (retained.div_ceil(2), retained / 2);
    let part = |letters: &[char]| letters.iter().collect::<String>();
    part(&letters[..first]) + ELLIPSIS + &part(&letters[letters.len() - last..])
}

/// A panel to draw on. Clips to its borders.
struct Canvas(Panel);

impl Canvas {
    fn paste(&mut self, panel: &Panel, [left, top]: [usize; 2]) {
        for row in 0..panel.height {
            let start = 3 * ((top + row) * self.0.width + left);
            let line = &panel.rgb[3 * panel.width * row..3 * panel.width * (row + 1)];
            self.0.rgb[start..start + line.len()].copy_from_slice(line);
        }
    }

    /// Draws a text with its upper left corner at `x`, `y`.
    fn text(&mut self, text: &str, [x, y]: [usize; 2], fonts: &Fonts, colour: Rgb888) {
        for (number, letter) in text.chars().enumerate() {
            let font = font_of(letter, fonts).unwrap_or(fonts[0]);
            let at = Point::new((x + number * LETTER) as i32, y as i32);
            let letter = letter.to_string();
            match Text::with_baseline(&letter, at, MonoTextStyle::new(font, colour), Baseline::Top).draw(self) {
                Ok(_) => {}
                Err(never) => match never {},
            }
        }
    }

    /// Draws a text in the soft colour, centred at `x`.
    fn centred(&mut self, text: &str, [x, y]: [usize; 2]) {
        let width = text.chars().count() * LETTER;
        self.text(text, [x.saturating_sub(width.saturating_sub(1) / 2), y], &PLAIN, SOFT);
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.0.width as u32, self.0.height as u32)
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = embedded_graphics::Pixel<Rgb888>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        for embedded_graphics::Pixel(Point { x, y }, colour) in pixels {
            let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { continue };
            if x < self.0.width && y < self.0.height {
                let start = 3 * (y * self.0.width + x);
                self.0.rgb[start..start + 3].copy_from_slice(&[colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 96;

    fn cell(name: &str) -> Cell {
        let panel = |value: u8| Some(Panel { width: SIDE, height: SIDE, rgb: vec![value; 3 * SIDE * SIDE] });
        let row = [panel(11), panel(22), panel(33)];
        Cell {
            name: name.to_owned(),
            details: "1.9 KiB  ΔE 0.47".to_owned(),
            failed: false,
            rows: vec![row.clone(), row],
        }
    }

    fn pixel(panel: &Panel, [x, y]: [usize; 2]) -> [u8; 3] {
        let start = 3 * (y * panel.width + x);
        panel.rgb[start..start + 3].try_into().unwrap()
    }

    /// Counts the pixels of a rectangle that are not paper.
    fn drawn(panel: &Panel, [left, top]: [usize; 2], [width, height]: [usize; 2]) -> usize {
        let points = (0..height).flat_map(|y| (0..width).map(move |x| [left + x, top + y]));
        points.filter(|at| pixel(panel, *at) != [PAPER; 3]).count()
    }

    #[test]
    fn renderings_are_side_by_side_above_their_label() {
        let sheet = contact_sheet(&[cell("red_plastic")]);
        let top = MARGIN + LINE;
        for (number, value) in [11, 22, 33].into_iter().enumerate() {
            let left = MARGIN + number * (SIDE + GAP);
            assert_eq!(pixel(&sheet, [left, top]), [value; 3]);
            assert_eq!(pixel(&sheet, [left + SIDE - 1, top + 2 * SIDE + GAP - 1]), [value; 3]);
        }
        let label = top + 2 * (SIDE + GAP);
        assert!(drawn(&sheet, [MARGIN, label], [11 * LETTER, LINE]) > 100);
        assert_eq!(drawn(&sheet, [MARGIN + 11 * LETTER, label], [3 * SIDE - 11 * LETTER, LINE]), 0);
        assert!(drawn(&sheet, [MARGIN, MARGIN], [3 * SIDE, LINE]) > 100, "what the columns are");
    }

    #[test]
    fn labels_are_read_from_the_cell() {
        let one = contact_sheet(&[cell("red_plastic")]);
        assert!(one == contact_sheet(&[cell("red_plastic")]));
        assert!(one != contact_sheet(&[cell("red_plastik")]));
        assert!(one != contact_sheet(&[Cell { details: "1.9 KiB  ΔE 0.48".into(), ..cell("red_plastic") }]));
        assert!(one != contact_sheet(&[Cell { failed: true, ..cell("red_plastic") }]));
        // Fonts draw a "?" for letters that they lack.
        let details = |text: &str| contact_sheet(&[Cell { details: text.into(), ..cell("a") }]);
        for letter in ["Δ", "é", "ł", "ğ", "Ж"] {
            assert!(details(letter) != details("?"), "{letter}");
        }
    }

    #[test]
    fn letters_that_no_font_has_are_code_points() {
        assert_eq!(spelled("crème Δ Ж ?"), "crème Δ Ж ?");
        assert_eq!(spelled("木綿"), "U+6728U+7DBF");
        assert!(contact_sheet(&[cell("漢字")]) != contact_sheet(&[cell("木綿")]));
    }

    #[test]
    fn the_colour_scale_has_the_colours_of_differences_at_its_ends() {
        for count in [0, 1, 9] {
            let sheet = contact_sheet(&vec![cell("a"); count]);
            let top = sheet.height - MARGIN - BAR[1] - LINE;
            let ends = heat_map(&[0.0, DELTA_E_FULL_SCALE as f32], 2, 1, DELTA_E_FULL_SCALE).rgb;
            let left = MARGIN + BAR_MARGIN;
            for y in [top, top + BAR[1] - 1] {
                assert_eq!(pixel(&sheet, [left, y]), ends[..3]);
                assert_eq!(pixel(&sheet, [left + BAR[0] - 1, y]), ends[3..]);
            }
            for tick in 0..=TICKS {
                let x = left + tick * (BAR[0] - 1) / TICKS;
                assert_eq!(pixel(&sheet, [x, top + BAR[1]]), [INK.r(), INK.g(), INK.b()]);
                assert!(drawn(&sheet, [x - LETTER, top + BAR[1] + 3], [2 * LETTER, 13]) > 10, "{tick}");
            }
        }
    }

    #[test]
    fn many_cells_are_about_four_by_three() {
        for count in [5, 9, 20, 100, 1000] {
            let sheet = contact_sheet(&vec![Cell { rows: vec![[None, None, None]; 2], ..cell("a") }; count]);
            let renderings = contact_sheet(&vec![cell("a"); count]);
            for panel in [&sheet, &renderings] {
                let aspect = panel.width as f64 / panel.height as f64;
                assert!((0.9..1.9).contains(&aspect), "{count}: {} x {}", panel.width, panel.height);
            }
        }
    }

    #[test]
    fn cells_may_lack_renderings_or_be_smaller() {
        let blank = Cell { rows: Vec::new(), ..cell("failed") };
        let small = Panel { width: 3, height: 2, rgb: vec![7; 18] };
        let partly = Cell { rows: vec![[None, Some(small), None]], ..cell("partly") };
        let sheet = contact_sheet(&[cell("whole"), blank, partly]);
        assert!(sheet.rgb.chunks_exact(3).filter(|rgb| **rgb == [7; 3]).count() == 6);
        let alone = contact_sheet(&[Cell { rows: Vec::new(), ..cell("failed") }]);
        assert!(alone.rgb.len() == 3 * alone.width * alone.height);
    }

    #[test]
    fn long_names_lose_their_middle() {
        assert_eq!(shortened("as_it_is", 8), "as_it_is");
        assert_eq!(shortened("cc_ibiza_sunset_rgb", 11), "cc_i..._rgb");
        assert_eq!(shortened("cc_ibiza_sunset_rgb", 12).chars().count(), 12);
        assert_eq!(shortened("ΔΔΔΔΔΔ", 5), "Δ...Δ");
    }
}
