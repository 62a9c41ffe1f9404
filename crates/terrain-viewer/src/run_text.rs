//! A method with its settings as one line: `tin selector=algorithm1 tolerance_px=0.25`. The keys are those of suites.

use clap::ValueEnum;
use terrain_lod::{MethodName, Run, Settings};

/// Reads a line; what it leaves out has the bench's default, but that work is done behind the frames.
pub fn parse(line: &str) -> Result<Run, String> {
    let mut words = line.split_whitespace();
    let name = words.next().ok_or("expected a method, such as tin or htp-instanced")?;
    let method = MethodName::from_str(name, false).map_err(|_| {
        let names: Vec<&str> = MethodName::value_variants().iter().map(|method| method.as_str()).collect();
        format!("method '{name}': expected one of {}", names.join(", "))
    })?;
    let mut text = String::new();
    for word in words {
        let (key, value) = word.split_once('=').ok_or_else(|| format!("'{word}': expected KEY=VALUE"))?;
        let is_bare = value.parse::<f64>().is_ok() || matches!(value, "true" | "false");
        text += &if is_bare { format!("{key} = {value}\n") } else { format!("{key} = '{value}'\n") };
    }
    let first_line = |error: toml::de::Error| error.message().lines().next().unwrap_or_default().to_owned();
    let given: toml::Table = toml::from_str(&text).map_err(first_line)?;
    let mut settings: toml::Table = toml::Table::try_from(live()).expect("settings become TOML");
    settings.extend(given);
    let settings = settings.try_into().map_err(|error| format!("{name}: {}", first_line(error)))?;
    let run = Run { method, settings };
    run.validate().map_err(|fault| fault.to_string())?;
    Ok(run)
}

/// The bench's defaults, with workers behind the plans.
pub fn live() -> Settings {
    use terrain_lod::{LoadingName, ScheduleName};
    Settings { schedule: ScheduleName::Live, loading: LoadingName::Live, ..Settings::default() }
}

/// The line of a run, which [`parse`] takes: what differs from the defaults.
pub fn of(run: &Run) -> String {
    let table = |settings: &Settings| toml::Table::try_from(settings).expect("settings become TOML");
    let usual = table(&live());
    let differs = |(key, value): &(String, toml::Value)| usual.get(key) != Some(value);
    let word = |(key, value): (String, toml::Value)| match value {
        toml::Value::String(name) => format!(" {key}={name}"),
        value => format!(" {key}={value}"),
    };
    let words: String = table(&run.settings).into_iter().filter(differs).map(word).collect();
    run.method.as_str().to_owned() + &words
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_lod::{ScheduleName, SelectorName};

    #[test]
    fn a_line_is_a_run_and_back() {
        let run = parse("tin tolerance_px=0.25 selector=algorithm1 max_spacing=8").unwrap();
        let Settings { tolerance_px, selector, max_spacing, schedule, .. } = run.settings;
        assert_eq!((tolerance_px, selector, max_spacing), (0.25, SelectorName::Algorithm1, Some(8)));
        assert_eq!(schedule, ScheduleName::Live);
        assert_eq!(parse(&of(&run)).unwrap(), run);
        assert_eq!(of(&parse("htp").unwrap()), "htp");
        assert_eq!(parse("htp tolerance_px=2").unwrap().settings.tolerance_px, 2.0, "an integer is a number too");
    }

    #[test]
    fn what_is_wrong_is_said() {
        let refused = |line| parse(line).unwrap_err();
        assert!(refused("").contains("expected a method"));
        assert!(refused("tim").contains("expected one of tin, htp"));
        assert!(refused("tin tolerance").contains("expected KEY=VALUE"));
        assert!(refused("tin colour=red").contains("unknown field `colour`"), "{}", refused("tin colour=red"));
        assert!(refused("tin patch=7").contains("patch"), "{}", refused("tin patch=7"));
    }
}
