//! Binary STL: 80 bytes of title, the number of triangles, and for each its normal, its corners and two zero bytes.

use std::io::{self, Write};

use super::{Mesh, too_large};

pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let triangles = u32::try_from(mesh.triangles.len()).map_err(|_| too_large("more than 2^32 triangles"))?;
    let mut title = [b' '; 80];
    let text = b"terrain: x east, y up, z south, in metres";
    title[..text.len()].copy_from_slice(text);
    out.write_all(&title)?;
    out.write_all(&triangles.to_le_bytes())?;
    for corners in &mesh.triangles {
        let corners = corners.map(|index| mesh.positions_m[index as usize]);
        for number in [normal(corners)].iter().chain(&corners).flatten() {
            out.write_all(&number.to_le_bytes())?;
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}

/// The unit normal of a triangle; zeros where it has no area.
fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let from_a = |p: [f32; 3]| [0, 1, 2].map(|i| (p[i] - a[i]) as f64);
    let (u, v) = (from_a(b), from_a(c));
    let cross = [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
    let length = cross.iter().map(|n| n * n).sum::<f64>().sqrt();
    if length > 0.0 { cross.map(|n| (n / length) as f32) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_file::MeshFormat;
    use crate::mesh_file::tests::{POSITIONS, written};

    #[test]
    fn fifty_bytes_a_triangle() {
        let file = written(MeshFormat::Stl);
        assert_eq!(file.len(), 84 + 2 * 50);
        assert_eq!(file[80..84], 2_u32.to_le_bytes());
        let number = |at: usize| f32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        let corner = |at: usize| [number(at), number(at + 4), number(at + 8)];
        assert_eq!([corner(84 + 12), corner(84 + 24), corner(84 + 36)], [POSITIONS[0], POSITIONS[1], POSITIONS[2]]);
        assert!(corner(84)[1] > 0.9, "up");
        assert_eq!(normal([[0.0; 3]; 3]), [0.0; 3]);
    }
}
