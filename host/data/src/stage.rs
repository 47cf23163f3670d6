//! What appears whole or not at all: a folder or a file is written beside its place, and renamed at the end.
//!
//! What is being written is locked: of a process that was stopped nobody holds the lock, and the next that writes there
//! removes what it left.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::{DatasetError, Problem};

/// A folder in the making; removed where it is dropped before [`Stage::finish`].
#[derive(Debug)]
pub struct Stage {
    to: PathBuf,
    at: PathBuf,
    _lock: Option<File>,
}

impl Stage {
    /// For `folder`, which must not be there, or be empty.
    ///
    /// # Errors
    /// A folder with content; what the file system answers.
    pub fn begin(folder: &Path) -> Result<Self, DatasetError> {
        if folder.exists() && fs::read_dir(folder).map_err(of(folder))?.next().is_some() {
            return Err(DatasetError::of_file(folder, Problem::FolderNotEmpty));
        }
        Self::at(folder, place(folder)).map_err(of(folder))
    }

    /// For `folder`, which may have content: what is written comes beside it, files of the same names are replaced.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn within(folder: &Path) -> Result<Self, DatasetError> {
        // In a folder that is there, which may be another disk than the one it lies in.
        let place = if folder.is_dir() { place(&folder.join("new")) } else { place(folder) };
        Self::at(folder, place).map_err(of(folder))
    }

    fn at(to: &Path, at: PathBuf) -> io::Result<Self> {
        remove_left(&at);
        fs::create_dir_all(&at)?;
        Ok(Stage { to: to.to_owned(), _lock: locked(&at), at })
    }

    /// Where to write.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.at
    }

    /// Moves the folder to its place.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn finish(self) -> Result<(), DatasetError> {
        self.finish_with("")
    }

    /// The same; of a folder with content by file, the one named `last` after all others.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn finish_with(self, last: &str) -> Result<(), DatasetError> {
        let moved = if self.at.parent() == Some(self.to.as_path()) {
            move_into(&self.at, &self.to, last)
        } else {
            fs::rename(&self.at, &self.to)
        };
        moved.map_err(of(&self.to))
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // After `finish` there is nothing at this place, or an empty folder.
        let _ = fs::remove_dir_all(&self.at);
    }
}

/// Writes a file that appears whole or not at all; one that is there is replaced, with its permissions.
///
/// # Errors
/// What the file system answers.
pub fn write_file(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    let (partial, mut file) = Partial::begin(path)?;
    file.write_all(content.as_ref())?;
    partial.finish()
}

/// A file in the making; removed where it is dropped before [`Partial::finish`].
#[derive(Debug)]
pub(crate) struct Partial {
    to: PathBuf,
    at: PathBuf,
}

impl Partial {
    /// With the file to write into.
    pub(crate) fn begin(path: &Path) -> io::Result<(Self, File)> {
        let there = fs::metadata(path).ok();
        if there.as_ref().is_some_and(|known| !known.is_file()) {
            // A pipe or a device is no file that can be renamed.
            return Ok((Partial { to: path.to_owned(), at: path.to_owned() }, File::create(path)?));
        }
        // A link stays one.
        let to = if there.is_some() { fs::canonicalize(path)? } else { path.to_owned() };
        let at = place(&to);
        remove_left(&at);
        let file = File::create(&at)?;
        let partial = Partial { to, at };
        // Where the file system has no locks, it may be left behind.
        let _ = file.try_lock();
        if let Some(known) = there {
            file.set_permissions(known.permissions())?;
        }
        Ok((partial, file))
    }

    /// Moves the file to its place.
    pub(crate) fn finish(self) -> io::Result<()> {
        if self.at == self.to { Ok(()) } else { fs::rename(&self.at, &self.to) }
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if self.at != self.to {
            // After `finish` there is nothing at this place.
            let _ = fs::remove_file(&self.at);
        }
    }
}

/// Beside `path`, named after it and this process.
fn place(path: &Path) -> PathBuf {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    path.with_file_name(format!(".{name}.{}.partial", std::process::id()))
}

/// Removes what other processes that are gone left of the same name as `at`.
fn remove_left(at: &Path) {
    let stem = |path: &Path| -> Option<String> {
        let name = path.file_name()?.to_string_lossy().into_owned();
        let (stem, process) = name.strip_suffix(".partial")?.rsplit_once('.')?;
        process.parse::<u32>().ok().map(|_| stem.to_owned())
    };
    let folder = at.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        if stem(&path) == stem(at) && locked(&path).is_some() {
            let _ = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
    }
}

/// The lock of what is at `path`, until it is dropped; `None` where another has it, or the file system has no locks.
fn locked(path: &Path) -> Option<File> {
    let file = File::open(path).ok()?;
    file.try_lock().ok().map(|()| file)
}

/// Moves all that is in `from` into `to`, `last` at the end.
fn move_into(from: &Path, to: &Path, last: &str) -> io::Result<()> {
    fs::create_dir_all(to)?;
    let mut entries: Vec<PathBuf> =
        fs::read_dir(from)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    entries.sort_by_key(|path| path.file_name().is_some_and(|name| name == last));
    for path in entries {
        let goal = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            move_into(&path, &goal, last)?;
        } else {
            fs::rename(&path, &goal)?;
        }
    }
    Ok(())
}

fn of(path: &Path) -> impl Fn(io::Error) -> DatasetError + '_ {
    move |error| DatasetError::of_file(path, Problem::Io(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("listed").flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_appears_whole_or_not_at_all_and_one_with_content_is_refused() {
        let parent = tempfile::tempdir().expect("folder");
        let to = parent.path().join("data");
        {
            let stage = Stage::begin(&to).expect("begun");
            fs::write(stage.folder().join("a"), "1").expect("written");
            assert!(!to.exists());
        }
        assert!(names(parent.path()).is_empty(), "a stage that is given up leaves nothing");
        let stage = Stage::begin(&to).expect("begun");
        fs::write(stage.folder().join("a"), "2").expect("written");
        stage.finish().expect("moved");
        assert_eq!(fs::read_to_string(to.join("a")).expect("there"), "2");
        assert_eq!(names(parent.path()), ["data"]);
        let refused = Stage::begin(&to).expect_err("has content").to_string();
        assert!(refused.contains("choose another"), "{refused}");
    }

    #[test]
    fn what_is_written_into_a_folder_with_content_comes_beside_it_at_the_end_or_not_at_all() {
        let parent = tempfile::tempdir().expect("folder");
        let to = parent.path().join("data");
        fs::create_dir_all(to.join("trials")).expect("made");
        for (name, text) in [("notes.txt", "mine"), ("list", "old"), ("trials/a", "old")] {
            fs::write(to.join(name), text).expect("written");
        }
        let write = |stage: &Stage| {
            fs::create_dir_all(stage.folder().join("trials")).expect("made");
            fs::write(stage.folder().join("list"), "new").expect("written");
            fs::write(stage.folder().join("trials/b"), "new").expect("written");
        };
        let read = |name: &str| fs::read_to_string(to.join(name)).expect("there");
        let stage = Stage::within(&to).expect("begun");
        write(&stage);
        drop(stage);
        assert_eq!(
            (names(&to).join(" "), read("list").as_str()),
            ("list notes.txt trials".to_owned(), "old")
        );
        let stage = Stage::within(&to).expect("begun");
        write(&stage);
        assert_eq!(read("list"), "old");
        stage.finish_with("list").expect("moved");
        assert_eq!(names(&to), ["list", "notes.txt", "trials"]);
        assert_eq!(names(&to.join("trials")), ["a", "b"]);
        assert_eq!((read("list"), read("notes.txt")), ("new".to_owned(), "mine".to_owned()));
        let new = parent.path().join("new");
        let stage = Stage::within(&new).expect("begun");
        write(&stage);
        assert!(!new.exists());
        stage.finish().expect("moved");
        assert_eq!(names(&new), ["list", "trials"]);
        assert_eq!(names(parent.path()), ["data", "new"]);
    }

    #[test]
    fn what_a_process_that_was_stopped_left_is_removed_and_what_is_being_written_is_not() {
        let parent = tempfile::tempdir().expect("folder");
        let to = parent.path().join("data");
        let left = parent.path().join(".data.1.partial");
        fs::create_dir(&left).expect("made");
        fs::write(left.join("a"), "half").expect("written");
        fs::create_dir(parent.path().join(".data.other.1.partial")).expect("made");
        let writing = locked(&left).expect("free");
        let stage = Stage::begin(&to).expect("begun");
        assert!(left.join("a").exists(), "its process writes");
        drop(stage);
        drop(writing);
        Stage::begin(&to).expect("begun").finish().expect("moved");
        assert_eq!(names(parent.path()), [".data.other.1.partial", "data"]);
    }

    #[test]
    fn a_file_appears_whole_or_stays_as_it_was() {
        let parent = tempfile::tempdir().expect("folder");
        let to = parent.path().join("page.html");
        fs::write(parent.path().join(".page.html.1.partial"), "half").expect("written");
        write_file(&to, "one").expect("written");
        let (partial, mut file) = Partial::begin(&to).expect("begun");
        file.write_all(b"half").expect("written");
        assert_eq!(fs::read_to_string(&to).expect("there"), "one");
        drop(partial);
        assert_eq!(names(parent.path()), ["page.html"]);
        write_file(&to, "two").expect("written");
        assert_eq!(fs::read_to_string(&to).expect("there"), "two");
        assert!(write_file(parent.path(), "a folder").is_err());
        assert!(write_file(&parent.path().join("none/page.html"), "no folder").is_err());
        assert_eq!(names(parent.path()), ["page.html"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_replaced_keeps_its_permissions_and_the_links_to_it() {
        use std::os::unix::fs::PermissionsExt as _;
        let parent = tempfile::tempdir().expect("folder");
        let [to, link] = ["model.toml", "link.toml"].map(|name| parent.path().join(name));
        fs::write(&to, "one").expect("written");
        fs::set_permissions(&to, fs::Permissions::from_mode(0o640)).expect("set");
        std::os::unix::fs::symlink("model.toml", &link).expect("linked");
        write_file(&link, "two").expect("written");
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&to).expect("there"), "two");
        assert_eq!(fs::metadata(&to).expect("there").permissions().mode() & 0o777, 0o640);
        write_file(Path::new("/dev/null"), "a device").expect("written");
    }
}
