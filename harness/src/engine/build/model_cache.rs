//! The folder of built models: found by content, built aside under a lock, pruned by last use and by size.
//!
//! ```text
//! runtime/<key>/*.o                     Verilator's runtime, compiled once for each kind of model
//! runtime/trial-<key>/                  a newer Verilator that passed the trial
//! models/<key>/<variant>/model.so       the model; one <variant> for each contents of the included files
//! models/<key>/<variant>/record.json    ports, internals, warnings, manifest of includes
//! locks/<key>                           locked shared while loading, exclusively while building or removing
//! aside/<random>/                       a build in progress; its file `alive` is locked as long as its process lives
//! ```

use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use sha2::{Digest, Sha256};

use super::job::BuildJob;
use super::tool::{self, Verilator, Version};
use super::{Build, Record, Trace, absolute, runtime, trial, unity};
use crate::engine::error::BuildError;
use crate::engine::model::Library;

/// The sources of the generator. They are part of every key, so that a model of another generator is not found.
const GENERATOR: [&str; 11] = [
    unity::SHIM,
    runtime::HOOKS,
    include_str!("generated.rs"),
    include_str!("manifest.rs"),
    include_str!("ports.rs"),
    include_str!("unity.rs"),
    include_str!("job.rs"),
    include_str!("hierarchy/mod.rs"),
    include_str!("hierarchy/json.rs"),
    include_str!("hierarchy/registers.rs"),
    include_str!("hierarchy/xml.rs"),
];

/// Loads the model from the cache; builds it first if it is not there.
pub(super) fn load_or_build(build: &Build) -> Result<Library, BuildError> {
    let cache = Cache::open(build)?;
    let verilator = Verilator::find(build.verilator.as_deref())?;
    let compiler = tool::find_compiler()?;
    let sources = build.sources.iter().map(|p| absolute(p)).collect::<Result<Vec<_>, _>>()?;
    let includes = include_folders(build, &sources)?;
    let key = model_key(build, &verilator, &compiler, &sources, &includes)?;
    {
        let _reading = cache.lock_to_load(&key)?;
        if let Some(library) = cache.find(&key, &includes) {
            return Ok(library);
        }
    }
    let _building = cache.lock(&key, Sharing::Exclusive)?;
    // Another process may have built it while this one waited for the lock.
    if let Some(library) = cache.find(&key, &includes) {
        return Ok(library);
    }
    let version = verilator.version()?;
    if !version.is_known() && !build.on_trial {
        cache.try_out(build, &verilator, &compiler, &version)?;
    }
    let folder = cache.build_folder()?;
    let job = BuildJob {
        build,
        verilator: &verilator,
        compiler: &compiler,
        sources: &sources,
        includes: &includes,
        folder: folder.path(),
    };
    let mut record =
        job.make(&version, |root| cache.runtime(&verilator, &compiler, root, build.trace, build.coverage.any()))?;
    record.library_hash = hash_file(&folder.path().join("model.so"))?;
    let library = cache.keep(&key, &folder, &record)?;
    cache.prune(&key);
    Ok(library)
}

/// The time after which an unused model is removed.
const MAX_UNUSED_AGE: Duration = Duration::from_secs(30 * 24 * 3600);

struct Cache {
    root: PathBuf,
    limit: u64,
}

enum Sharing {
    Shared,
    Exclusive,
}

/// The folder of a build in progress, removed when dropped.
struct BuildFolder {
    folder: tempfile::TempDir,
    _alive: File,
}

impl BuildFolder {
    fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Cache {
    fn open(build: &Build) -> Result<Cache, BuildError> {
        let root = match &build.cache {
            Some(folder) => folder.clone(),
            None => hoverlock_cache::folder()?,
        };
        let limit = build.cache_limit.unwrap_or_else(|| {
            let asked = std::env::var("HOVERLOCK_CACHE_LIMIT").ok().and_then(|text| text.parse::<u64>().ok());
            asked.unwrap_or(2048).saturating_mul(1 << 20)
        });
        for folder in ["runtime", "models", "locks", "aside"] {
            let path = root.join(folder);
            std::fs::create_dir_all(&path).map_err(|source| BuildError::Cache { path, source })?;
        }
        let root = root.canonicalize().map_err(|source| BuildError::Cache { path: root, source })?;
        Ok(Cache { root, limit })
    }

    /// Waits for the lock of a key. The system releases it when the process ends, however it ends.
    fn lock(&self, key: &str, sharing: Sharing) -> Result<File, BuildError> {
        let path = self.root.join("locks").join(key);
        let locked = File::options().create(true).append(true).open(&path).and_then(|file| {
            match sharing {
                Sharing::Shared => file.lock_shared()?,
                Sharing::Exclusive => file.lock()?,
            }
            Ok(file)
        });
        locked.map_err(|source| BuildError::Cache { path, source })
    }

    /// Takes the lock under which a model is loaded. A read-only cache works too: its locks are opened for reading, and
    /// without a lock file nobody with write access has built or removed the model.
    fn lock_to_load(&self, key: &str) -> Result<Option<File>, BuildError> {
        match self.lock(key, Sharing::Shared) {
            Err(BuildError::Cache { path, source }) if is_read_only(&source) => {
                let Ok(file) = File::open(&path) else { return Ok(None) };
                file.lock_shared().map_err(|source| BuildError::Cache { path, source })?;
                Ok(Some(file))
            }
            other => other.map(Some),
        }
    }

    /// Returns the built model whose includes are unchanged, if its files are complete.
    fn find(&self, key: &str, includes: &[PathBuf]) -> Option<Library> {
        let folder = self.root.join("models").join(key);
        let mut variants: Vec<PathBuf> = std::fs::read_dir(folder).ok()?.filter_map(|e| Some(e.ok()?.path())).collect();
        variants.sort();
        for variant in variants {
            let Some(record) = read_record(&variant) else {
                // Damaged: a fresh build takes its place.
                let _ = std::fs::remove_dir_all(&variant);
                continue;
            };
            if !record.manifest.iter().all(|(path, hash)| is_current(path, hash, includes)) {
                continue;
            }
            let library = variant.join("model.so");
            let whole = hash_file(&library).is_ok_and(|hash| hash == record.library_hash);
            let loaded = whole.then(|| Library::load(&library, record).ok()).flatten();
            if loaded.is_none() {
                let _ = std::fs::remove_dir_all(&variant);
                continue;
            }
            touch(&variant);
            return loaded;
        }
        None
    }

    fn build_folder(&self) -> Result<BuildFolder, BuildError> {
        let parent = self.root.join("aside");
        let make = || -> io::Result<BuildFolder> {
            let folder = tempfile::Builder::new().prefix("build-").tempdir_in(&parent)?;
            let alive = File::create(folder.path().join("alive"))?;
            alive.lock()?;
            Ok(BuildFolder { folder, _alive: alive })
        };
        make().map_err(|source| BuildError::Cache { path: parent.clone(), source })
    }

    /// Tries a Verilator that the harness does not know on a small design, once for each; an error if a value is not
    /// what it should be.
    fn try_out(
        &self,
        build: &Build,
        verilator: &Verilator,
        compiler: &Path,
        version: &Version,
    ) -> Result<(), BuildError> {
        let mut hash = Hash::new();
        GENERATOR.iter().for_each(|part| hash.add(part.as_bytes()));
        for part in [include_str!("trial.rs"), trial::DESIGN] {
            hash.add(part.as_bytes());
        }
        hash.add(tool::fingerprint(&verilator.path).as_bytes());
        hash.add(tool::fingerprint(compiler).as_bytes());
        let key = format!("trial-{}", hash.finish());
        let _lock = self.lock(&key, Sharing::Exclusive)?;
        let passed = self.root.join("runtime").join(&key);
        if !passed.exists() {
            let folder = self.build_folder()?;
            trial::run(build, &verilator.path, folder.path()).map_err(|reason| BuildError::VersionUnsupported {
                found: version.text.clone(),
                path: verilator.path.clone(),
                reason: format!("on a small design that the harness tries newer versions with, {reason}"),
            })?;
            std::fs::create_dir_all(&passed).map_err(|source| BuildError::Cache { path: passed.clone(), source })?;
        }
        touch(&passed);
        Ok(())
    }

    /// Returns the folder of the runtime's objects and headers, compiled if it does not exist.
    fn runtime(
        &self,
        verilator: &Verilator,
        compiler: &Path,
        root: &Path,
        trace: Trace,
        coverage: bool,
    ) -> Result<PathBuf, BuildError> {
        let mut hash = Hash::new();
        let kind = format!("{trace:?} {coverage}");
        for part in [runtime::HOOKS, include_str!("runtime.rs"), &kind, &root.display().to_string()] {
            hash.add(part.as_bytes());
        }
        hash.add(tool::fingerprint(&verilator.path).as_bytes());
        hash.add(tool::fingerprint(compiler).as_bytes());
        let key = format!("runtime-{}", hash.finish());
        let folder = self.root.join("runtime").join(&key);
        let _lock = self.lock(&key, Sharing::Exclusive)?;
        if !is_whole(&folder) {
            let building = self.build_folder()?;
            let into = building.path().join("objects");
            let kept = |source| BuildError::Cache { path: folder.clone(), source };
            std::fs::create_dir(&into).map_err(kept)?;
            runtime::compile_runtime(compiler, root, trace, coverage, &into)?;
            std::fs::write(into.join(HASHES), hashes(&into)?).map_err(kept)?;
            let _ = std::fs::remove_dir_all(&folder);
            std::fs::rename(&into, &folder).map_err(kept)?;
        }
        touch(&folder);
        Ok(folder)
    }

    /// Moves a finished build into its place and loads it from there.
    fn keep(&self, key: &str, folder: &BuildFolder, record: &Record) -> Result<Library, BuildError> {
        let mut hash = Hash::new();
        for (path, content) in &record.manifest {
            hash.add(path.as_os_str().as_encoded_bytes());
            hash.add(content.as_bytes());
        }
        let variant = self.root.join("models").join(key).join(hash.finish());
        let moved = || -> io::Result<()> {
            let ready = folder.path().join("ready");
            std::fs::create_dir(&ready)?;
            std::fs::rename(folder.path().join("model.so"), ready.join("model.so"))?;
            std::fs::write(ready.join("record.json"), serde_json::to_vec(record)?)?;
            touch(&ready);
            if let Some(parent) = variant.parent() {
                std::fs::create_dir_all(parent)?;
            }
            let _ = std::fs::remove_dir_all(&variant);
            std::fs::rename(&ready, &variant)
        };
        moved().map_err(|source| BuildError::Cache { path: variant.clone(), source })?;
        Library::load(&variant.join("model.so"), record.clone())
    }

    /// Removes what killed builds left, what was not used for [`MAX_UNUSED_AGE`], and, while the models are larger than
    /// the limit, those used longest ago.
    fn prune(&self, own_key: &str) {
        for path in children(&self.root.join("aside")) {
            // No lock on `alive` means that its process is gone; no such file, that it is being made or half removed.
            let dead = match File::open(path.join("alive")) {
                Ok(file) => !matches!(file.try_lock(), Err(TryLockError::WouldBlock)),
                Err(_) => age(modified(&path)) > Duration::from_secs(3600),
            };
            if dead {
                let _ = std::fs::remove_dir_all(path);
            }
        }
        for folder in children(&self.root.join("runtime")) {
            if age(last_use(&folder)) > MAX_UNUSED_AGE {
                self.remove_unless_in_use(&name_of(&folder), &folder);
            }
        }
        let mut entries: Vec<(SystemTime, u64, String, PathBuf)> = Vec::new();
        for folder in children(&self.root.join("models")) {
            for variant in children(&folder) {
                entries.push((last_use(&variant), size(&variant), name_of(&folder), variant));
            }
        }
        let mut total: u64 = entries.iter().map(|e| e.1).sum();
        entries.sort();
        for (used, bytes, key, variant) in entries {
            if total <= self.limit && age(used) <= MAX_UNUSED_AGE {
                break;
            }
            if key != own_key && self.remove_unless_in_use(&key, &variant) {
                total -= bytes;
                // Where this was the key's last variant, its folder is empty now.
                let _ = variant.parent().map(std::fs::remove_dir);
            }
        }
    }

    /// Removes a folder, unless the lock of its key says that it is being loaded or built. A model that a process has
    /// loaded stays mapped into that process.
    fn remove_unless_in_use(&self, key: &str, folder: &Path) -> bool {
        let lock = File::options().create(true).append(true).open(self.root.join("locks").join(key));
        lock.is_ok_and(|lock| lock.try_lock().is_ok() && std::fs::remove_dir_all(folder).is_ok())
    }
}

/// Returns the include folders of the build, then the folders of the sources, each once.
fn include_folders(build: &Build, sources: &[PathBuf]) -> Result<Vec<PathBuf>, BuildError> {
    let mut folders: Vec<PathBuf> = Vec::new();
    let asked = build.includes.iter().map(|p| absolute(p)).collect::<Result<Vec<_>, _>>()?;
    for folder in asked.into_iter().chain(sources.iter().filter_map(|s| s.parent().map(Path::to_owned))) {
        if !folders.contains(&folder) {
            folders.push(folder);
        }
    }
    Ok(folders)
}

/// Returns the hash of everything that a build depends on, except the includes, which are known only afterwards.
fn model_key(
    build: &Build,
    verilator: &Verilator,
    compiler: &Path,
    sources: &[PathBuf],
    includes: &[PathBuf],
) -> Result<String, BuildError> {
    let mut hash = Hash::new();
    GENERATOR.iter().for_each(|part| hash.add(part.as_bytes()));
    hash.add(env!("CARGO_PKG_VERSION").as_bytes());
    runtime::CXX_FLAGS.iter().for_each(|flag| hash.add(flag.as_bytes()));
    hash.add(tool::fingerprint(&verilator.path).as_bytes());
    hash.add(tool::fingerprint(compiler).as_bytes());
    build.verilator_arguments(sources, includes).iter().for_each(|argument| hash.add(argument.as_bytes()));
    // The patterns of both lists are separated by the count between them.
    build.internals.iter().for_each(|pattern| hash.add(pattern.as_bytes()));
    hash.add(&build.internals.len().to_le_bytes());
    build.forceable.iter().for_each(|pattern| hash.add(pattern.as_bytes()));
    hash.add(format!("{:?} {:?} {:?} {}", build.trace, build.coverage, build.initial, build.registers).as_bytes());
    for source in sources {
        hash.add(hash_file(source)?.as_bytes());
    }
    Ok(hash.finish())
}

/// The list of a folder's files and the hashes of their contents, in that folder.
const HASHES: &str = "hashes";

fn hashes(folder: &Path) -> Result<String, BuildError> {
    let mut files = children(folder);
    files.sort();
    let line = |file: &PathBuf| Ok(format!("{} {}\n", hash_file(file)?, name_of(file)));
    files.iter().map(line).collect()
}

/// Returns `true` if a folder has every file of its list, undamaged.
fn is_whole(folder: &Path) -> bool {
    let Ok(list) = std::fs::read_to_string(folder.join(HASHES)) else { return false };
    let undamaged = |(hash, name): (&str, &str)| hash_file(&folder.join(name)).is_ok_and(|now| now == hash);
    !list.is_empty() && list.lines().all(|line| line.split_once(' ').is_some_and(undamaged))
}

fn is_read_only(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
}

/// Returns `true` if an included file is unchanged, and no folder that is searched earlier has a file of that name now.
fn is_current(path: &Path, hash: &str, includes: &[PathBuf]) -> bool {
    let shadowed = includes.iter().find_map(|folder| {
        let below = path.strip_prefix(folder).ok()?;
        Some(includes.iter().take_while(|f| *f != folder).any(|earlier| earlier.join(below).exists()))
    });
    !shadowed.unwrap_or(false) && hash_file(path).is_ok_and(|now| now == hash)
}

fn read_record(variant: &Path) -> Option<Record> {
    serde_json::from_slice(&std::fs::read(variant.join("record.json")).ok()?).ok()
}

/// SHA-256 over parts, each with its length, so that different lists of parts have different hashes.
struct Hash(Sha256);

impl Hash {
    fn new() -> Hash {
        Hash(Sha256::new())
    }

    fn add(&mut self, part: &[u8]) {
        self.0.update((part.len() as u64).to_le_bytes());
        self.0.update(part);
    }

    fn finish(self) -> String {
        hex(&self.0.finalize()[..16])
    }
}

pub(super) fn hash_file(path: &Path) -> Result<String, BuildError> {
    let content = std::fs::read(path).map_err(|source| BuildError::Source { path: path.to_owned(), source })?;
    Ok(hex(&Sha256::digest(content)))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

fn children(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).map(|entries| entries.filter_map(|e| Some(e.ok()?.path())).collect()).unwrap_or_default()
}

fn size(folder: &Path) -> u64 {
    children(folder).iter().filter_map(|f| Some(std::fs::metadata(f).ok()?.len())).sum()
}

/// Marks an entry as used now; does nothing in a read-only cache.
fn touch(folder: &Path) {
    let _ = File::create(folder.join("used")).and_then(|file| file.set_modified(SystemTime::now()));
}

/// Returns when an entry was used last.
fn last_use(entry: &Path) -> SystemTime {
    let used = entry.join("used");
    if used.exists() { modified(&used) } else { modified(entry) }
}

fn modified(path: &Path) -> SystemTime {
    std::fs::metadata(path).and_then(|m| m.modified()).unwrap_or(SystemTime::UNIX_EPOCH)
}

fn age(time: SystemTime) -> Duration {
    SystemTime::now().duration_since(time).unwrap_or_default()
}

fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
