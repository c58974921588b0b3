//! The parameter section of a C3D file: named arrays in named groups.
//!
//! Each entry states where the next one begins, and the reader follows only that. Real files leave out the
//! description that should end an entry, or its length byte.
use super::processor::Processor;

/// The parameters of a file, as they lie in it. An entry takes a few words of memory more than its bytes.
pub(super) struct Parameters<'a> {
    pub(super) processor: Processor,
    groups: Vec<(u8, &'a [u8])>,
    parameters: Vec<Parameter<'a>>,
    /// Whether the section ends in an entry that reaches beyond it.
    pub(super) is_damaged: bool,
    /// The byte of the section at which the last entry ends.
    pub(super) end: usize,
}

/// An array of numbers or letters.
struct Parameter<'a> {
    group: u8,
    name: &'a [u8],
    kind: Kind,
    dimensions: &'a [u8],
    data: &'a [u8],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Letters,
    Bytes,
    Words,
    Floats,
}

impl<'a> Parameters<'a> {
    /// Reads the entries of `section`, which begins behind the section's four bytes of preface.
    pub(super) fn read(section: &'a [u8], processor: Processor) -> Self {
        let mut out =
            Self { processor, groups: Vec::new(), parameters: Vec::new(), is_damaged: false, end: 0 };
        let mut at = 0;
        while let Some(&[name_length, group]) = section.get(at..at + 2) {
            // A negative length marks a locked entry, which is for editors.
            let name_length = usize::from((name_length as i8).unsigned_abs());
            let group = group as i8;
            if name_length == 0 || group == 0 {
                return out;
            }
            let offset_at = at + 2 + name_length;
            let Some((name, offset)) =
                section.get(at + 2..offset_at).zip(word(section, offset_at, processor))
            else {
                break;
            };
            let next = (offset != 0).then(|| offset_at + usize::from(offset));
            let end = next.unwrap_or(section.len()).min(section.len());
            let Some(body) = section.get(offset_at + 2..end) else { break };
            let mut used = 0;
            if group < 0 {
                out.groups.push((group.unsigned_abs(), name));
            } else if let Some(parameter) = Parameter::read(group as u8, name, body) {
                used = 2 + parameter.dimensions.len() + parameter.data.len();
                out.parameters.push(parameter);
            }
            out.end = next.unwrap_or(offset_at + 2 + used);
            match next {
                Some(next) => at = next,
                None => return out,
            }
        }
        // A section may be full, without a mark of its end.
        out.is_damaged = at > section.len() || at + 2 <= section.len();
        out
    }

    /// All numbers of a parameter, in the order of the file; none if there is no such parameter or it holds
    /// letters. Words are read without sign, because numbers of frames, points and blocks have outgrown the
    /// sign.
    pub(super) fn numbers(&self, group: &str, name: &str) -> Vec<f64> {
        let Some(parameter) = self.find(group, name) else { return Vec::new() };
        let data = parameter.data;
        match parameter.kind {
            Kind::Letters => Vec::new(),
            Kind::Bytes => data.iter().map(|&b| f64::from(b)).collect(),
            Kind::Words => data.as_chunks().0.iter().map(|&w| f64::from(self.processor.word(w))).collect(),
            Kind::Floats => data.as_chunks().0.iter().map(|&f| self.processor.float(f)).collect(),
        }
    }

    /// The first number of a parameter.
    pub(super) fn number(&self, group: &str, name: &str) -> Option<f64> {
        self.numbers(group, name).first().copied()
    }

    /// A whole number from 0 to 2³² − 1: one number, or two 16-bit words with the low one first.
    pub(super) fn count(&self, group: &str, name: &str) -> Option<u32> {
        let value = match (self.find(group, name)?.kind, self.numbers(group, name).as_slice()) {
            (Kind::Words, &[low, high, ..]) => low + 65536.0 * high,
            (_, &[value, ..]) => value,
            _ => return None,
        };
        (value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value)).then_some(value as u32)
    }

    /// The texts of a parameter of letters; `None` where there is no such parameter.
    pub(super) fn texts(&self, group: &str, name: &str) -> Option<Vec<&'a [u8]>> {
        let parameter = self.find(group, name).filter(|found| found.kind == Kind::Letters)?;
        let length = parameter.dimensions.first().map_or(1, |&length| usize::from(length));
        Some(if length == 0 { Vec::new() } else { parameter.data.chunks(length).collect() })
    }

    /// The first parameter of that name in any group of that name.
    fn find(&self, group: &str, name: &str) -> Option<&Parameter<'a>> {
        let same = |found: &[u8], wanted: &str| found.trim_ascii().eq_ignore_ascii_case(wanted.as_bytes());
        let mut is_wanted = [false; 1 << u8::BITS];
        for (id, _) in self.groups.iter().filter(|(_, found)| same(found, group)) {
            is_wanted[usize::from(*id)] = true;
        }
        let mut parameters = self.parameters.iter();
        parameters.find(|parameter| is_wanted[usize::from(parameter.group)] && same(parameter.name, name))
    }
}

impl<'a> Parameter<'a> {
    /// `body` begins with the type and ends where the next entry begins.
    fn read(group: u8, name: &'a [u8], body: &'a [u8]) -> Option<Self> {
        let (&[kind, rank], rest) = body.split_first_chunk()?;
        let (kind, size) = match kind as i8 {
            -1 => (Kind::Letters, 1),
            1 => (Kind::Bytes, 1),
            2 => (Kind::Words, 2),
            4 => (Kind::Floats, 4),
            _ => return None,
        };
        let (dimensions, rest) = rest.split_at_checked(usize::from(rank))?;
        // No more than the file has, even if the dimensions say more.
        let data = dimensions.iter().try_fold(size, |bytes: usize, &n| bytes.checked_mul(usize::from(n)));
        let data = &rest[..data.unwrap_or(usize::MAX).min(rest.len())];
        Some(Self { group, name, kind, dimensions, data })
    }
}

/// The word at a place of `bytes`, if it is there.
pub(super) fn word(bytes: &[u8], at: usize, processor: Processor) -> Option<u16> {
    Some(processor.word(*bytes.get(at..)?.first_chunk()?))
}
