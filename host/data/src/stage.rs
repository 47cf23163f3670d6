//! A folder that appears whole or not at all: written beside its place, renamed at the end.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::{DatasetError, Problem};

/// A folder in the making; removed where it is dropped before [`Stage::finish`].
#[derive(Debug)]
pub struct Stage {
    to: PathBuf,
    at: PathBuf,
}

impl Stage {
    /// For `folder`, which must not be there, or be empty.
    ///
    /// # Errors
    /// A folder with content; what the file system answers.
    pub fn begin(folder: &Path) -> Result<Self, DatasetError> {
        let io = |error: std::io::Error| DatasetError::of_file(folder, Problem::Io(error.to_string()));
        if folder.exists() && fs::read_dir(folder).map_err(io)?.next().is_some() {
            return Err(DatasetError::of_file(folder, Problem::FolderNotEmpty));
        }
        let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let at = folder.with_file_name(format!(".{name}.{}.partial", std::process::id()));
        if at.exists() {
            fs::remove_dir_all(&at).map_err(io)?;
        }
        fs::create_dir_all(&at).map_err(io)?;
        Ok(Stage { to: folder.to_owned(), at })
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
        fs::rename(&self.at, &self.to)
            .map_err(|error| DatasetError::of_file(&self.to, Problem::Io(error.to_string())))
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // After `finish` there is nothing at this place.
        let _ = fs::remove_dir_all(&self.at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_appears_whole_or_not_at_all_and_one_with_content_is_refused() {
        let parent = tempfile::tempdir().expect("folder");
        let to = parent.path().join("data");
        let names = || fs::read_dir(parent.path()).expect("listed").count();
        {
            let stage = Stage::begin(&to).expect("begun");
            fs::write(stage.folder().join("a"), "1").expect("written");
            assert!(!to.exists());
        }
        assert_eq!(names(), 0, "a stage that is given up leaves nothing");
        let stage = Stage::begin(&to).expect("begun");
        fs::write(stage.folder().join("a"), "2").expect("written");
        stage.finish().expect("moved");
        assert_eq!(fs::read_to_string(to.join("a")).expect("there"), "2");
        assert_eq!(names(), 1);
        let refused = Stage::begin(&to).expect_err("has content").to_string();
        assert!(refused.contains("choose another"), "{refused}");
    }
}
