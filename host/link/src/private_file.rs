//! Files that only their owner reads: keys, and what a module is provisioned with.
//!
//! A file is made with mode 0600 whatever the umask, never through a symbolic link, and takes the place of another only
//! if told so, all at once. One that its group or others may read or write is refused. Limits: modes are those of Unix; elsewhere a file
//! has the rights of its folder.

use std::fs::{self, DirBuilder, File, Metadata};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;
use thiserror::Error;

/// Why a file cannot be had, or not be made.
#[derive(Debug, Error)]
pub enum PrivateFileError {
    /// No such file.
    #[error("{}: no such file", path.display())]
    Missing {
        /// Which file.
        path: PathBuf,
    },
    /// The operating system will not have it read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A folder, a device or a pipe.
    #[error("{}: is not a file", path.display())]
    NotAFile {
        /// Which path.
        path: PathBuf,
    },
    /// Others than its owner can read or write it.
    #[error(
        "{}: mode {mode:04o} lets others than its owner read or write it: run `chmod 600 {}` (and change the secret in \
         it if others may have read it)",
        path.display(), path.display()
    )]
    Open {
        /// Which file.
        path: PathBuf,
        /// Its mode.
        mode: u32,
    },
    /// There is such a file already.
    #[error("{}: exists already and is left as it is; --force replaces it", path.display())]
    Exists {
        /// Which file.
        path: PathBuf,
    },
    /// No secret is written through a symbolic link.
    #[error("{}: is a symbolic link: name the file itself", path.display())]
    Link {
        /// Which path.
        path: PathBuf,
    },
    /// The operating system will not have it written.
    #[error("cannot write {}: {source}", path.display())]
    Unwritable {
        /// Which file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

/// Reads as much of `path` as `buffer` holds.
pub fn read(path: &Path, buffer: &mut [u8]) -> Result<usize, PrivateFileError> {
    let unreadable = |source: io::Error| match source.kind() {
        ErrorKind::NotFound => PrivateFileError::Missing { path: path.to_owned() },
        _ => PrivateFileError::Unreadable { path: path.to_owned(), source },
    };
    // A pipe would be waited for.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(PrivateFileError::NotAFile { path: path.to_owned() });
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

/// Writes `bytes` to `path`, for its owner's eyes; in place of a file that is there only with `force`.
pub fn write(path: &Path, bytes: &[u8], force: bool) -> Result<(), PrivateFileError> {
    let unwritable = |source| PrivateFileError::Unwritable { path: path.to_owned(), source };
    let exists = || PrivateFileError::Exists { path: path.to_owned() };
    match fs::symlink_metadata(path) {
        Ok(there) if there.is_symlink() => return Err(PrivateFileError::Link { path: path.to_owned() }),
        Ok(there) if !there.is_file() => return Err(PrivateFileError::NotAFile { path: path.to_owned() }),
        Ok(_) if !force => return Err(exists()),
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(unwritable(error)),
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder {
        create_folder(folder).map_err(unwritable)?;
    }
    let folder = folder.unwrap_or(Path::new("."));
    // Under an unused name first, so that the former file is whole until the new one is; removed if it comes to nothing.
    let mut file = NamedTempFile::new_in(folder).map_err(unwritable)?;
    restrict(file.as_file()).map_err(unwritable)?;
    check_private(path, &file.as_file().metadata().map_err(unwritable)?)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(unwritable)?;
    let named = if force { file.persist(path) } else { file.persist_noclobber(path) };
    named.map_err(|failed| match failed.error.kind() {
        ErrorKind::AlreadyExists => exists(),
        _ => unwritable(failed.error),
    })?;
    // That the folder names the file is on the disk too; not every file system can be asked to.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Mode 0600: the umask may have taken from the owner what the file was made with.
#[cfg(unix)]
fn restrict(file: &File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(fs::Permissions::from_mode(0o600))
}

/// Modes are those of Unix.
#[cfg(not(unix))]
fn restrict(_: &File) -> io::Result<()> {
    Ok(())
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
fn check_private(path: &Path, metadata: &Metadata) -> Result<(), PrivateFileError> {
    use std::os::unix::fs::PermissionsExt;
    let mode = metadata.permissions().mode() & 0o7777;
    if mode & 0o066 != 0 {
        return Err(PrivateFileError::Open { path: path.to_owned(), mode });
    }
    Ok(())
}

/// Modes are those of Unix.
#[cfg(not(unix))]
fn check_private(_: &Path, _: &Metadata) -> Result<(), PrivateFileError> {
    Ok(())
}
