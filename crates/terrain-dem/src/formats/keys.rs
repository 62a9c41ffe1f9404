//! Headers of keys and values, one pair a line.

use crate::formats::words;

/// Keys in small letters and their values, in the file's order.
pub struct Keys(Vec<(String, String)>);

impl Keys {
    pub fn parse(text: &str) -> Self {
        let pair = |line: &str| {
            let (key, value) = line.trim().split_once(|c: char| c.is_ascii_whitespace() || c == '=' || c == ':')?;
            let value = value.trim_start_matches(|c: char| c.is_ascii_whitespace() || c == '=' || c == ':');
            Some((key.trim_start_matches('\u{feff}').to_lowercase(), value.to_owned()))
        };
        Self(text.lines().filter_map(pair).collect())
    }

    /// The first word of a value.
    pub fn word(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(name, _)| name == key)?.1.split_ascii_whitespace().next()
    }

    pub fn number(&self, key: &str) -> Option<f64> {
        words::number(self.word(key)?)
    }

    /// Whether these keys are numbers, where they are there at all.
    pub fn check_numbers(&self, keys: &[&str]) -> Result<(), String> {
        match keys.iter().find_map(|key| Some((key, self.word(key)?)).filter(|(_, word)| words::number(word).is_none()))
        {
            Some((key, word)) => Err(format!("`{key}` is {}; expected a number: mend it", word.escape_debug())),
            None => Ok(()),
        }
    }

    /// A count of cells, which some programs write as `100.0`.
    pub fn cells(&self, key: &str) -> Result<u32, String> {
        let expected = "expected a whole number above 0: convert it again";
        let word = self.word(key).ok_or_else(|| format!("no `{key}`; {expected}"))?;
        let number =
            words::number(word).filter(|number| number.fract() == 0.0 && (1.0..=u32::MAX as f64).contains(number));
        number.map(|number| number as u32).ok_or_else(|| format!("`{key}` is {}; {expected}", word.escape_debug()))
    }

    /// A count or a place in bytes, or what is usual.
    pub fn whole(&self, key: &str, usual: u64) -> Result<u64, String> {
        let Some(word) = self.word(key) else { return Ok(usual) };
        word.parse().map_err(|_| format!("`{key}` is {}; expected a whole number", word.escape_debug()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings() {
        let keys = Keys::parse("\u{feff}NCOLS\t 10\r\nnrows=7.0\n\nByteOrder : M\nnbits 1x\n");
        assert_eq!((keys.cells("ncols"), keys.cells("nrows"), keys.word("byteorder")), (Ok(10), Ok(7), Some("M")));
        assert!(keys.cells("nbits").is_err() && keys.cells("none").is_err() && keys.whole("nbits", 1).is_err());
        assert_eq!(keys.whole("skipbytes", 4), Ok(4));
    }
}
