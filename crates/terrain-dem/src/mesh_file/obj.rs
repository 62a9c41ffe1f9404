//! Wavefront OBJ: lines of text, indices from 1, one index for position and normal.

use std::io::{self, Write};

use super::Mesh;

pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    writeln!(out, "# x east, y up, z south, in metres; faces counter-clockwise seen from above")?;
    for [x, y, z] in &mesh.positions_m {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [x, y, z] in &mesh.normals {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|index| index as u64 + 1);
        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::mesh_file::MeshFormat;
    use crate::mesh_file::tests::written;

    #[test]
    fn lines() {
        let text = String::from_utf8(written(MeshFormat::Obj)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 4 + 4 + 2);
        assert_eq!([lines[3], lines[5], lines[10]], ["v 10.5 -2 0", "vn 0 1 0", "f 3//3 2//2 4//4"]);
    }
}
