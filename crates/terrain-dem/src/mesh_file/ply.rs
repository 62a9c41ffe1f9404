//! Binary little-endian PLY. Normals are left out: readers make their own.

use std::io::{self, Write};

use super::{Mesh, too_large};

pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let (vertices, triangles) = (&mesh.positions_m, &mesh.triangles);
    if vertices.len() > i32::MAX as usize {
        return Err(too_large("more than 2^31 vertices"));
    }
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment x east, y up, z south, in metres; triangles counter-clockwise seen from above\n\
         element vertex {}\n\
         property float x\n\
         property float y\n\
         property float z\n\
         element face {}\n\
         property list uchar int vertex_indices\n\
         end_header\n",
        vertices.len(),
        triangles.len()
    )?;
    for coordinate in vertices.as_flattened() {
        out.write_all(&coordinate.to_le_bytes())?;
    }
    for triangle in triangles {
        out.write_all(&[3])?;
        for index in triangle {
            out.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::mesh_file::MeshFormat;
    use crate::mesh_file::tests::written;

    #[test]
    fn header_and_bytes() {
        let file = written(MeshFormat::Ply);
        let end = b"end_header\n";
        let body = end.len() + file.windows(end.len()).position(|window| window == end).unwrap();

        let header: Vec<&str> = std::str::from_utf8(&file[..body]).unwrap().lines().collect();
        assert_eq!(header[..2], ["ply", "format binary_little_endian 1.0"]);
        let elements: Vec<&str> = header.iter().copied().filter(|line| line.starts_with("element")).collect();
        assert_eq!(elements, ["element vertex 4", "element face 2"]);
        assert!(header.contains(&"property list uchar int vertex_indices"));

        assert_eq!(file.len() - body, 4 * 12 + 2 * 13);
        assert_eq!(file[body + 24..body + 28], 10.5f32.to_le_bytes());
        assert_eq!(file[body + 48 + 13..], [3, 2, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0]);
    }
}
