//! MAT files of version 5, as MATLAB writes them.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use ndarray::Array2;
use std::io::Write;

/// An element of a MAT file: tag, body, padding.
pub(crate) fn element(kind: u32, body: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), u32::try_from(body.len()).unwrap().to_le_bytes()].concat();
    bytes.extend(body);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// An element whose body of at most four bytes stands in its tag.
pub(crate) fn small_element(kind: u32, body: &[u8]) -> Vec<u8> {
    let head = kind | u32::try_from(body.len()).unwrap() << 16;
    let mut bytes = head.to_le_bytes().to_vec();
    bytes.extend(body);
    bytes.resize(8, 0);
    bytes
}

/// A variable of a class, with the elements that the class has.
pub(crate) fn variable(class: u32, size: [usize; 2], name: &str, content: &[Vec<u8>]) -> Vec<u8> {
    let flags: Vec<u8> = [class, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
    let size: Vec<u8> =
        size.iter().flat_map(|n| i32::try_from(*n).unwrap().to_le_bytes()).collect();
    let name = name.as_bytes();
    let name = if name.len() <= 4 { small_element(1, name) } else { element(1, name) };
    let parts = [element(6, &flags), element(5, &size), name, content.concat()].concat();
    element(14, &parts)
}

pub(crate) fn doubles(name: &str, values: &Array2<f64>) -> Vec<u8> {
    // By column.
    let by_column: Vec<u8> = values.t().iter().flat_map(|x| x.to_le_bytes()).collect();
    variable(6, [values.nrows(), values.ncols()], name, &[element(9, &by_column)])
}

/// A structure of one element.
pub(crate) fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let names = fields.iter().flat_map(|(name, _)| {
        let mut name = name.as_bytes().to_vec();
        name.resize(32, 0);
        name
    });
    let names: Vec<u8> = names.collect();
    let mut content = vec![small_element(5, &32_i32.to_le_bytes()), element(1, &names)];
    content.extend(fields.iter().map(|(_, value)| value.clone()));
    variable(2, [1, 1], name, &content)
}

pub(crate) fn compressed(variable: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(variable).unwrap();
    let body = encoder.finish().unwrap();
    let length = u32::try_from(body.len()).unwrap();
    [15_u32.to_le_bytes().to_vec(), length.to_le_bytes().to_vec(), body].concat()
}

pub(crate) fn mat_of(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = vec![b' '; 124];
    bytes[..19].copy_from_slice(b"MATLAB 5.0 MAT-file");
    bytes.extend([0, 1, b'I', b'M']);
    bytes.extend(variables.concat());
    bytes
}
