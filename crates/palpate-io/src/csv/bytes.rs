//! The bytes of a file: read up to a limit, and unpacked where they are compressed.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::read_error::{ReadError, ReadProblem};

/// Largest file that is read: far more than a day of samples, far less than the memory of the machine.
const MAX_MIB: u64 = 512;
/// Most that a compressed file is unpacked to: still a day of samples, and bounded more tightly because a file of a few hundred kilobytes
/// can hold it.
const MAX_UNPACKED_MIB: u64 = 128;
/// What a gzip file begins with.
const GZIP: [u8; 2] = [0x1f, 0x8b];

const BYTES_PER_MIB: u64 = 1024 * 1024;

/// The bytes of a file, as by [`bytes_from`].
///
/// # Errors
/// As [`bytes_from`]; also when there is no such file, or it is a folder.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let failed = |error| ReadError::io(path, &error);
    let file = File::open(path).map_err(failed)?;
    let name = path.to_string_lossy();
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(ReadError::in_file(&name, ReadProblem::IsFolder));
    }
    bytes_from(&name, file)
}

/// The bytes of a log from anything that can be read, such as standard input, up to a limit of 512 MiB; where they are compressed by gzip
/// they are unpacked, to 128 MiB at most. `name` stands for the file in messages.
///
/// # Errors
/// It cannot be read or unpacked, or is larger than that.
pub fn bytes_from(name: &str, source: impl Read) -> Result<Vec<u8>, ReadError> {
    let bytes = up_to(MAX_MIB * BYTES_PER_MIB, source).map_err(|error| ReadError::io(Path::new(name), &error))?;
    let Some(bytes) = bytes else {
        return Err(ReadError::in_file(name, ReadProblem::TooLarge { limit_mib: MAX_MIB }));
    };
    if !bytes.starts_with(&GZIP) {
        return Ok(bytes);
    }
    let unpacked = up_to(MAX_UNPACKED_MIB * BYTES_PER_MIB, MultiGzDecoder::new(&bytes[..]));
    match unpacked {
        Ok(Some(unpacked)) => Ok(unpacked),
        Ok(None) => Err(ReadError::in_file(name, ReadProblem::UnpacksTooLarge { limit_mib: MAX_UNPACKED_MIB })),
        Err(_) => Err(ReadError::in_file(name, ReadProblem::DamagedGzip)),
    }
}

/// All that there is to read; `None` where it is more than `limit` bytes.
fn up_to(limit: u64, source: impl Read) -> std::io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    source.take(limit + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= limit).then_some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_is_read_than_the_limit() {
        assert_eq!(up_to(3, &b"abc"[..]).ok(), Some(Some(b"abc".to_vec())));
        assert_eq!(up_to(3, &b"abcd"[..]).ok(), Some(None));
        assert_eq!(up_to(3, std::io::repeat(b'a')).ok(), Some(None));
    }
}
