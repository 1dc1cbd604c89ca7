//! Scans of a JPEG: counts their blocks, because decoders fill missing ones with grey.
//!
//! Entropy-coded data are walked through without computing coefficients (ITU-T T.81, F.2.2 and G.2).

use brdfc_formats::memory::filled;

/// Maximum number of bytes after the last block before a marker that are ignored.
const MAX_STRAY_BYTES: usize = 8;
/// Maximum number of scans of a file.
const MAX_SCANS: usize = 1000;
/// Maximum number of pixels, for which progressive files take up to 3 bits of memory each.
const MAX_PIXELS: usize = 1 << 28;
/// Bits that the table of a Huffman code resolves at once.
const QUICK_BITS: u32 = 9;
const DEFINE_HUFFMAN: u8 = 0xc4;
const DEFINE_RESTART: u8 = 0xdd;
const BASELINE: u8 = 0xc0;
const EXTENDED: u8 = 0xc1;
const PROGRESSIVE: u8 = 0xc2;

/// A component: sampling factors, and what scans have coded so far.
#[derive(Debug, Clone)]
struct Component {
    id: u8,
    sampling: [usize; 2],
    /// Blocks across and down, with those that fill the last MCUs.
    blocks: [usize; 2],
    /// A bit per coefficient of each block that is not 0, for progressive files.
    nonzero: Vec<u64>,
    /// Number of missing bits of each coefficient; `u8::MAX` before its first scan.
    missing: [u8; 64],
}

/// Tables and components of a file, and its progress.
#[derive(Debug, Clone, Default)]
pub(super) struct Scans {
    is_progressive: bool,
    size: [usize; 2],
    components: Vec<Component>,
    /// DC and AC tables.
    tables: [[Option<Huffman>; 4]; 2],
    restart_interval: usize,
    count: usize,
}

/// Component of a scan with its tables.
#[derive(Clone, Copy)]
struct Member<'a> {
    component: usize,
    tables: [Option<&'a Huffman>; 2],
}

/// Coefficients of a scan, and their bits before and after it.
#[derive(Clone, Copy)]
struct Band {
    start: usize,
    end: usize,
    high: u8,
    low: u8,
}

impl Scans {
    /// Reads a segment that defines tables, a restart interval or the frame.
    pub(super) fn define(&mut self, marker: u8, contents: &[u8]) -> Result<(), String> {
        match marker {
            DEFINE_HUFFMAN => self.define_huffman(contents),
            DEFINE_RESTART => {
                let interval = contents.first_chunk().ok_or("an incomplete restart interval")?;
                self.restart_interval = usize::from(u16::from_be_bytes(*interval));
                Ok(())
            }
            BASELINE | EXTENDED | PROGRESSIVE if !self.components.is_empty() => Err("two frames".to_owned()),
            BASELINE | EXTENDED | PROGRESSIVE => {
                self.is_progressive = marker == PROGRESSIVE;
                self.define_frame(contents).ok_or_else(|| "an invalid frame".to_owned())?
            }
            0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                Err(format!("JPEG process SOF{}: only Huffman-coded baseline and progressive files", marker & 15))
            }
            _ => Ok(()),
        }
    }

    fn define_huffman(&mut self, mut contents: &[u8]) -> Result<(), String> {
        while let Some((class, rest)) = contents.split_first() {
            let wrong = || "an invalid Huffman table".to_owned();
            let (counts, rest) = rest.split_first_chunk::<16>().ok_or_else(wrong)?;
            let total = counts.iter().map(|count| usize::from(*count)).sum();
            let symbols = rest.get(..total).ok_or_else(wrong)?;
            let place = self.tables.get_mut(usize::from(class >> 4)).and_then(|of| of.get_mut(usize::from(class & 15)));
            *place.ok_or_else(wrong)? = Some(Huffman::new(counts, symbols).ok_or_else(wrong)?);
            contents = &rest[total..];
        }
        Ok(())
    }

    fn define_frame(&mut self, contents: &[u8]) -> Option<Result<(), String>> {
        let ([precision, h1, h0, w1, w0, count], rest) = contents.split_first_chunk()?;
        if *precision != 8 {
            return Some(Err(format!("JPEG of {precision} bits")));
        }
        self.size = [[*w1, *w0], [*h1, *h0]].map(|side| usize::from(u16::from_be_bytes(side)));
        if self.size[0] * self.size[1] > MAX_PIXELS {
            return Some(Err(format!("JPEG of {} x {} pixels", self.size[0], self.size[1])));
        }
        // Grey or colour; readers refuse four components.
        if ![1, 3].contains(count) {
            return Some(Err(format!("JPEG of {count} components")));
        }
        let parts = rest.as_chunks::<3>().0.get(..usize::from(*count))?;
        let sampling: Vec<[usize; 2]> =
            parts.iter().map(|part| [part[1] >> 4, part[1] & 15].map(usize::from)).collect();
        if parts.is_empty() || self.size.contains(&0) || sampling.iter().flatten().any(|n| !(1..=4).contains(n)) {
            return None;
        }
        let most = [0, 1].map(|k| sampling.iter().map(|factors| factors[k]).max().unwrap_or(1));
        // Decoders disagree about the rest of the channels.
        if [0, 1].iter().any(|k| sampling[0][*k] < most[*k]) {
            return Some(Err("JPEG whose luma is sampled more coarsely than its chroma".to_owned()));
        }
        let mcus = [0, 1].map(|k| self.size[k].div_ceil(8 * most[k]));
        for (part, sampling) in parts.iter().zip(sampling) {
            let blocks = [mcus[0] * sampling[0], mcus[1] * sampling[1]];
            let count = if self.is_progressive { blocks[0] * blocks[1] } else { 0 };
            let nonzero = match filled("JPEG coefficients", count, 0) {
                Ok(nonzero) => nonzero,
                Err(error) => return Some(Err(error.to_string())),
            };
            self.components.push(Component { id: part[0], sampling, blocks, nonzero, missing: [u8::MAX; 64] });
        }
        Some(Ok(()))
    }

    /// Walks through the scan whose header this is and whose data begin at `at`; returns where they end.
    pub(super) fn walk(&mut self, header: &[u8], jpeg: &[u8], at: usize) -> Result<usize, String> {
        self.count += 1;
        if self.count > MAX_SCANS {
            return Err(format!("more than {MAX_SCANS} scans"));
        }
        // The tables leave while components change.
        let tables = std::mem::take(&mut self.tables);
        let (members, band) = self.members(header, &tables).ok_or("an invalid header of a scan")?;
        let mut bits = Bits { jpeg, at, window: 0, count: 0 };
        let walked = self.blocks_of(&members, band, &mut bits);
        let end = walked.and_then(|()| bits.finish()).map_err(|problem| {
            format!(
                "scan {}, {problem}: the JPEG of {} x {} pixels is truncated or broken",
                self.count, self.size[0], self.size[1]
            )
        })?;
        for member in &members {
            self.components[member.component].missing[band.start..=band.end].fill(band.low);
        }
        self.tables = tables;
        Ok(end)
    }

    fn members<'a>(&self, header: &[u8], tables: &'a [[Option<Huffman>; 4]; 2]) -> Option<(Vec<Member<'a>>, Band)> {
        let (count, rest) = header.split_first()?;
        let (parts, rest) = rest.split_at_checked(2 * usize::from(*count))?;
        let mut members = Vec::new();
        for [id, of] in parts.as_chunks().0 {
            let component = self.components.iter().position(|component| component.id == *id)?;
            let tables = [tables[0].get(usize::from(of >> 4))?.as_ref(), tables[1].get(usize::from(of & 15))?.as_ref()];
            members.push(Member { component, tables });
        }
        let [start, end, bits] = *rest.first_chunk()?;
        let band = match self.is_progressive {
            true => Band { start: usize::from(start), end: usize::from(end), high: bits >> 4, low: bits & 15 },
            false => Band { start: 0, end: 63, high: 0, low: 0 },
        };
        let is_valid =
            band.start <= band.end && band.end < 64 && (!self.is_progressive || (band.start == 0) == (band.end == 0));
        let alone = members.len() == 1 || (band.start == 0 && members.len() > 1);
        (is_valid && alone).then_some((members, band))
    }

    fn blocks_of(&mut self, members: &[Member<'_>], band: Band, bits: &mut Bits<'_>) -> Result<(), String> {
        let most = [0, 1].map(|k| self.components.iter().map(|one| one.sampling[k]).max().unwrap_or(1));
        // The blocks of a single component have no order of MCUs, and fill no last MCU.
        let alone = members.len() == 1;
        let mcus = [0, 1].map(|k| match self.components[members[0].component].sampling[k] {
            factor if alone => (self.size[k] * factor).div_ceil(most[k]).div_ceil(8),
            _ => self.size[k].div_ceil(8 * most[k]),
        });
        let total = mcus[0] * mcus[1];
        let mut run = 0;
        for mcu in 0..total {
            let missing = |problem: &str| format!("{problem} after {mcu} of {total} units");
            if self.restart_interval > 0 && mcu > 0 && mcu % self.restart_interval == 0 {
                bits.restart((mcu / self.restart_interval - 1) % 8).map_err(|problem| missing(&problem))?;
                run = 0;
            }
            let [column, row] = [mcu % mcus[0], mcu / mcus[0]];
            for member in members {
                let component = &mut self.components[member.component];
                let [across, down] = if alone { [1, 1] } else { component.sampling };
                for block in 0..across * down {
                    let at = (row * down + block / across) * component.blocks[0] + column * across + block % across;
                    let walked = match component.nonzero.get_mut(at) {
                        Some(nonzero) => bits.progressive(member.tables, band, nonzero, &mut run),
                        None => bits.sequential(member.tables),
                    };
                    walked.ok_or_else(|| missing("no valid data"))?;
                }
            }
        }
        Ok(())
    }

    /// Checks that scans have coded all bits of all coefficients.
    pub(super) fn check_complete(&self) -> Result<(), String> {
        let incomplete = self.components.iter().filter(|component| component.missing != [0; 64]).count();
        if self.components.is_empty() || incomplete > 0 {
            let total = self.components.len();
            return Err(format!("{incomplete} of {total} components lack coefficients: the JPEG is truncated"));
        }
        Ok(())
    }
}

/// A Huffman code.
#[derive(Debug, Clone)]
struct Huffman {
    /// Length and symbol for each start of [`QUICK_BITS`] bits; length 0 for longer codes.
    quick: Vec<(u8, u8)>,
    /// Beyond the codes of each length, left-aligned in 16 bits, and the index of a symbol less its code.
    ends: [u32; 17],
    offsets: [i32; 17],
    symbols: Vec<u8>,
}

impl Huffman {
    fn new(counts: &[u8; 16], symbols: &[u8]) -> Option<Self> {
        let mut quick = vec![(0, 0); 1 << QUICK_BITS];
        let (mut ends, mut offsets) = ([0; 17], [0; 17]);
        let (mut code, mut index) = (0u32, 0usize);
        for length in 1..=16u32 {
            offsets[length as usize] = index as i32 - code as i32;
            for _ in 0..counts[length as usize - 1] {
                if code >= 1 << length {
                    return None;
                }
                if length <= QUICK_BITS {
                    let start = (code << (QUICK_BITS - length)) as usize;
                    quick[start..start + (1 << (QUICK_BITS - length))].fill((length as u8, symbols[index]));
                }
                (code, index) = (code + 1, index + 1);
            }
            ends[length as usize] = code << (16 - length);
            code <<= 1;
        }
        Some(Self { quick, ends, offsets, symbols: symbols.to_vec() })
    }
}

/// Entropy-coded bits, up to a marker.
struct Bits<'a> {
    jpeg: &'a [u8],
    at: usize,
    /// The next bits, left-aligned.
    window: u64,
    count: u32,
}

impl Bits<'_> {
    fn refill(&mut self) {
        while self.count <= 56 {
            let stuffed = match self.jpeg.get(self.at) {
                Some(0xff) if self.jpeg.get(self.at + 1) != Some(&0) => return,
                Some(byte) => usize::from(*byte == 0xff),
                None => return,
            };
            self.window |= u64::from(self.jpeg[self.at]) << (56 - self.count);
            self.count += 8;
            self.at += 1 + stuffed;
        }
    }

    /// Takes up to 16 bits.
    fn take(&mut self, length: u32) -> Option<u32> {
        if length == 0 {
            return Some(0);
        }
        if self.count < length {
            self.refill();
            if self.count < length {
                return None;
            }
        }
        let value = (self.window >> (64 - length)) as u32;
        self.window <<= length;
        self.count -= length;
        Some(value)
    }

    fn symbol(&mut self, code: &Huffman) -> Option<u8> {
        if self.count < 16 {
            self.refill();
        }
        let (length, symbol) = code.quick[(self.window >> (64 - QUICK_BITS)) as usize];
        if length > 0 {
            return self.take(u32::from(length)).map(|_| symbol);
        }
        let start = (self.window >> 48) as u32;
        let length = (QUICK_BITS as usize + 1..=16).find(|length| start < code.ends[*length])?;
        let value = self.take(length as u32)?;
        code.symbols.get(usize::try_from(value as i32 + code.offsets[length]).ok()?).copied()
    }

    /// Walks through a block of a sequential scan.
    fn sequential(&mut self, [dc, ac]: [Option<&Huffman>; 2]) -> Option<()> {
        let (dc, ac) = (dc?, ac?);
        let length = self.symbol(dc)?;
        self.take(Some(u32::from(length)).filter(|length| *length <= 11)?)?;
        let mut k = 1;
        while k < 64 {
            let symbol = self.symbol(ac)?;
            let (zeros, length) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            match (zeros, length) {
                (15, 0) => k += 16,
                (_, 0) => break,
                _ => {
                    k += zeros + 1;
                    self.take(length)?;
                }
            }
            if k > 64 {
                return None;
            }
        }
        Some(())
    }

    /// Walks through a block of a progressive scan. `run` counts blocks without further coefficients.
    fn progressive(
        &mut self,
        [dc, ac]: [Option<&Huffman>; 2],
        Band { start, end, high, .. }: Band,
        nonzero: &mut u64,
        run: &mut u32,
    ) -> Option<()> {
        if start == 0 {
            let length = if high == 0 { u32::from(self.symbol(dc?)?) } else { 1 };
            return self.take(Some(length).filter(|length| *length <= 11)?).map(|_| ());
        }
        let ac = ac?;
        let mut k = start;
        while *run == 0 && k <= end {
            let symbol = self.symbol(ac)?;
            let (mut zeros, length) = (u32::from(symbol >> 4), u32::from(symbol & 15));
            if length == 0 && zeros < 15 {
                *run = (1 << zeros) + self.take(zeros)?;
                break;
            }
            // The sign of a new coefficient of a refinement precedes the bits of those before it.
            self.take(length)?;
            if high == 0 {
                k += zeros as usize;
            } else {
                while k <= end && (*nonzero >> k & 1 == 1 || zeros > 0) {
                    if *nonzero >> k & 1 == 1 {
                        self.take(1)?;
                    } else {
                        zeros -= 1;
                    }
                    k += 1;
                }
            }
            if length > 0 {
                if k > end {
                    return None;
                }
                *nonzero |= 1 << k;
            }
            k += 1;
        }
        if *run > 0 {
            *run -= 1;
            if high > 0 {
                let rest = (u64::MAX >> (63 - end)) & (u64::MAX << k);
                for _ in 0..(*nonzero & rest).count_ones() {
                    self.take(1)?;
                }
            }
        }
        Some(())
    }

    /// Skips padding and a few other bytes; returns where the next marker is.
    fn finish(&mut self) -> Result<usize, String> {
        let mut stray = 0;
        loop {
            self.refill();
            stray += (self.count / 8) as usize;
            if self.count == 0 {
                break;
            }
            (self.window, self.count) = (0, 0);
        }
        match stray <= MAX_STRAY_BYTES {
            true => Ok(self.at),
            false => Err(format!("{stray} bytes after the last unit")),
        }
    }

    fn restart(&mut self, number: usize) -> Result<(), String> {
        let at = self.finish()?;
        let fill = self.jpeg[at..].iter().take_while(|byte| **byte == 0xff).count();
        let expected = 0xd0 + number as u8;
        if fill == 0 || self.jpeg.get(at + fill) != Some(&expected) {
            return Err(format!("no restart {number}"));
        }
        self.at = at + fill + 1;
        Ok(())
    }
}
