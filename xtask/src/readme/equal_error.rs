//! What the README shows of suites that sweep settings: each family's costs at one measured error, a DEM beside another.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::{caption_words, grouped, parse, read};
use crate::Fault;

/// What stands in the table: at this largest error in pixels, these costs and how many decimals they have.
const MEASURE: [&str; 2] = ["error_px_max", "1.0"];
const COSTS: [(&str, &str, usize); 3] =
    [("triangles_mean", "triangles", 0), ("draws_mean", "draws", 0), ("plan_ms_p50", "plan ms", 2)];
/// The settings that tell a family from the others.
const SETTINGS: [&str; 3] = ["selector", "metric", "k"];
/// Of a family that has too large an error with every setting, and of what is only known to be no larger.
const NOT_REACHED: &str = "not reached";
const AT_MOST: &str = "at most";

/// One number of `equal-error.csv`.
struct Cost {
    family: String,
    cost: String,
    state: String,
    value: Option<f64>,
}

/// The table of the records in some folders, one a DEM.
pub fn table(folders: &[PathBuf]) -> Result<String, Fault> {
    let (mut text, mut header, mut rule) = (String::new(), "| method |".to_owned(), "|---|".to_owned());
    let mut all = Vec::new();
    for folder in folders {
        let machine = parse(&folder.join("machine.json"), &read(&folder.join("machine.json"))?)?;
        let suite = parse(&folder.join("suite.json"), &read(&folder.join("suite.json"))?)?;
        let dem = machine["dem"].as_str().unwrap_or_default();
        let _ = writeln!(
            text,
            "- {dem} ({} x {} samples), flight {}, {} frames: `cargo xtask {}`",
            machine["dem_columns"],
            machine["dem_rows"],
            machine["flight"].as_str().unwrap_or_default(),
            machine["frames"],
            caption_words(&suite),
        );
        let names = COSTS.map(|(_, name, _)| name).join(" / ");
        let _ = write!(header, " {dem}: {names} |");
        rule += "---:|";
        all.push(costs(&folder.join("equal-error.csv"))?);
    }
    let _ = write!(text, "\n{header}\n{rule}\n");
    let mut families: Vec<&str> = Vec::new();
    for cost in all.iter().flatten() {
        if !families.contains(&cost.family.as_str()) {
            families.push(&cost.family);
        }
    }
    for family in families {
        let cells: Vec<String> = all.iter().map(|costs| cell(costs, family)).collect();
        let _ = writeln!(text, "| {family} | {} |", cells.join(" | "));
    }
    Ok(text)
}

/// All costs of a family at the error, or why there are none.
fn cell(costs: &[Cost], family: &str) -> String {
    let of = |name: &str| costs.iter().find(|cost| cost.family == family && cost.cost == name);
    if of(COSTS[0].0).is_none_or(|cost| cost.state == NOT_REACHED) {
        return NOT_REACHED.into();
    }
    let number = |(name, _, decimals): (&str, &str, usize)| {
        let value = of(name).and_then(|cost| cost.value).map(|value| grouped(&format!("{value:.decimals$}")));
        value.unwrap_or_default()
    };
    let sign = if of(COSTS[0].0).is_some_and(|cost| cost.state == AT_MOST) { "<= " } else { "" };
    sign.to_owned() + &COSTS.map(number).join(" / ")
}

/// What a file says of the error that is shown.
fn costs(path: &Path) -> Result<Vec<Cost>, Fault> {
    let text = read(path)?;
    let rows = super::rows(&text).map_err(|error| Fault::failure(format!("{}: {error}", path.display())))?;
    let shown = rows.iter().filter(|row| {
        let error_px = row.text("error_px").parse::<f64>();
        row.text("measure") == MEASURE[0] && error_px == MEASURE[1].parse::<f64>()
    });
    let cost = |row: &super::Row| {
        let settings = row.text("family").split(' ').filter_map(|word| word.split_once('='));
        let told = settings.filter(|(name, _)| SETTINGS.contains(name)).map(|(name, value)| format!(" {name}={value}"));
        Cost {
            family: format!("`{}`{}", row.text("method"), told.collect::<String>()),
            cost: row.text("cost").into(),
            state: row.text("state").into(),
            value: row.text("value").parse().ok(),
        }
    };
    Ok(shown.map(cost).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, dem: &str, rows: &str) -> PathBuf {
        let folder = folder.join(dem);
        std::fs::create_dir_all(&folder).unwrap();
        let machine = r#"{"dem":"DEM","dem_columns":9,"dem_rows":5,"flight":"turn","frames":60}"#.replace("DEM", dem);
        std::fs::write(folder.join("machine.json"), machine).unwrap();
        std::fs::write(folder.join("suite.json"), r#"{"command":["bench","--suite","s"]}"#).unwrap();
        let header = "bench,method,family,measure,error_px,cost,state,value\n";
        std::fs::write(folder.join("equal-error.csv"), header.to_owned() + rows).unwrap();
        folder
    }

    #[test]
    fn a_row_a_family_and_a_column_a_dem() {
        let folder = std::env::temp_dir().join(format!("terrain-xtask-equal-error-{}", std::process::id()));
        let a = "b,tin,selector=bounded patch=32,error_px_max,1.0,triangles_mean,is,12345.6\n\
                 b,tin,selector=bounded patch=32,error_px_max,1.0,draws_mean,is,45.2\n\
                 b,tin,selector=bounded patch=32,error_px_max,1.0,plan_ms_p50,is,1.234\n\
                 b,tin,selector=bounded patch=32,error_px_max,2.0,plan_ms_p50,is,9.0\n\
                 b,greedy,,error_px_max,1.0,triangles_mean,not reached,\n";
        let b = "b,tin,selector=bounded patch=32,error_px_max,1.0,triangles_mean,at most,7\n\
                 b,tin,selector=bounded patch=32,error_px_p99,1.0,draws_mean,is,3\n";
        let made = table(&[write(&folder, "a", a), write(&folder, "b", b)]).map_err(|fault| fault.message);
        std::fs::remove_dir_all(&folder).unwrap();
        let made = made.unwrap();
        assert!(
            made.starts_with("- a (9 x 5 samples), flight turn, 60 frames: `cargo xtask bench --suite s`\n- b "),
            "{made}"
        );
        assert!(made.contains("\n| `tin` selector=bounded | 12,346 / 45 / 1.23 | <= 7 /  /  |\n"), "{made}");
        assert!(made.ends_with("| `greedy` | not reached | not reached |\n"), "{made}");
    }
}
