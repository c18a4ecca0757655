//! Files that only their owner reads.

use std::fs::{self, DirBuilder, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use super::{KeyFileError, entropy};

/// Reads as much of `path` as `buffer` holds.
pub(super) fn read(path: &Path, buffer: &mut [u8]) -> Result<usize, KeyFileError> {
    let unreadable = |source: io::Error| match source.kind() {
        ErrorKind::NotFound => KeyFileError::Missing { path: path.to_owned() },
        _ => KeyFileError::Unreadable { path: path.to_owned(), source },
    };
    // A pipe would be waited for.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(KeyFileError::NotAFile { path: path.to_owned() });
    }
    let mut file = File::open(path).map_err(unreadable)?;
    // Of what was opened, whatever the path means by now.
    check_private(path, &file.metadata().map_err(unreadable)?)?;
    let mut length = 0;
    while length < buffer.len() {
        match file.read(&mut buffer[length..]) {
            Ok(0) => break,
            Ok(more) => length += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(unreadable(error)),
        }
    }
    Ok(length)
}

/// Writes `text` to `path`, for its owner's eyes; in place of a file that is there only with `force`.
pub(super) fn write(path: &Path, text: &[u8], force: bool) -> Result<(), KeyFileError> {
    let unwritable = |source| KeyFileError::Unwritable { path: path.to_owned(), source };
    let exists = || KeyFileError::Exists { path: path.to_owned() };
    let replaces = match fs::symlink_metadata(path) {
        Ok(there) if there.is_symlink() => return Err(KeyFileError::Link { path: path.to_owned() }),
        Ok(there) if !there.is_file() => return Err(KeyFileError::NotAFile { path: path.to_owned() }),
        Ok(_) if !force => return Err(exists()),
        Ok(_) => true,
        Err(error) if error.kind() == ErrorKind::NotFound => false,
        Err(error) => return Err(unwritable(error)),
    };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder {
        create_folder(folder).map_err(unwritable)?;
    }
    // The former key is whole until the new one is.
    let target = if replaces { beside(path)? } else { path.to_owned() };
    let mut file = create_new(&target).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => exists(),
        _ => unwritable(error),
    })?;
    let outcome = fill(path, &mut file, text)
        .and_then(|()| if replaces { fs::rename(&target, path).map_err(unwritable) } else { Ok(()) });
    if outcome.is_err() {
        let _ = fs::remove_file(&target);
        return outcome;
    }
    // That the folder names the file is on the disk too; not every file system can be asked to.
    let _ = File::open(folder.unwrap_or(Path::new("."))).and_then(|folder| folder.sync_all());
    Ok(())
}

fn fill(path: &Path, file: &mut File, text: &[u8]) -> Result<(), KeyFileError> {
    let unwritable = |source| KeyFileError::Unwritable { path: path.to_owned(), source };
    // The umask may have taken from the owner what it was made with; a file system may know no modes.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.set_permissions(fs::Permissions::from_mode(0o600)).map_err(unwritable)?;
    }
    check_private(path, &file.metadata().map_err(unwritable)?)?;
    file.write_all(text).and_then(|()| file.sync_all()).map_err(unwritable)
}

/// A name that nobody has, in the same folder.
fn beside(path: &Path) -> Result<PathBuf, KeyFileError> {
    let mut number = [0; 8];
    entropy::fill(&mut number)?;
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{:016x}", u64::from_le_bytes(number)));
    Ok(path.with_file_name(name))
}

/// A new file; a symbolic link counts as one that is there.
fn create_new(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

/// The folder and those it is in; such as are made are their owner's alone.
fn create_folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Refuses a file that others than its owner can read or write.
#[cfg(unix)]
fn check_private(path: &Path, metadata: &Metadata) -> Result<(), KeyFileError> {
    use std::os::unix::fs::PermissionsExt;
    let mode = metadata.permissions().mode() & 0o7777;
    if mode & 0o066 != 0 {
        return Err(KeyFileError::Open { path: path.to_owned(), mode });
    }
    Ok(())
}

/// Modes are those of Unix.
#[cfg(not(unix))]
fn check_private(_: &Path, _: &Metadata) -> Result<(), KeyFileError> {
    Ok(())
}
