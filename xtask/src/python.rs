//! The Python environments of the tests and the bench. A file in `xtask/` lists the packages of each.
use crate::run::{Result, command, copy, output, root, run, same_text, succeeds};
use std::path::PathBuf;

/// The only Python that both Blender's module and the oldest USD support.
const PYTHON: &str = "3.11";

/// An environment under `target/`. There are several, since each package brings its own USD.
struct Environment {
    folder: &'static str,
    /// The file in `xtask/` that names the packages and their versions.
    requirements: &'static str,
    /// Modules that can be imported after the installation, separated by commas.
    modules: &'static str,
}

const ENVIRONMENTS: [Environment; 6] = [
    Environment { folder: "venv", requirements: "requirements.txt", modules: "pxr.Usd, ezc3d" },
    Environment { folder: "venv-usd-24.3", requirements: "requirements-usd-24.3.txt", modules: "pxr.Usd" },
    Environment { folder: "venv-blender", requirements: "requirements-blender.txt", modules: "bpy" },
    Environment {
        folder: "clients/python",
        requirements: "requirements-clients.txt",
        modules: "PIL.Image, pyassimp, pxr.Usd, trimesh, vtk",
    },
    Environment {
        folder: "venv-python",
        requirements: "requirements-python.txt",
        modules: "ipykernel, matplotlib, mypy, nbclient, numpy, pandas, pytest, pxr.Usd, tqdm, trimesh",
    },
    Environment {
        folder: "venv-farm",
        requirements: "requirements-farm.txt",
        modules: "openjd.cli, openjd.model, openjd.sessions",
    },
];

/// Older Blenders that exports are opened with, and that the extension is for.
const BLENDERS: [Environment; 2] = [
    Environment {
        folder: "clients/blender-4.2",
        requirements: "requirements-blender-4.2.txt",
        modules: "bpy",
    },
    Environment {
        folder: "clients/blender-4.5",
        requirements: "requirements-blender-4.5.txt",
        modules: "bpy",
    },
];

const PEERS: Environment = Environment {
    folder: "venv-peers",
    requirements: "requirements-peers.txt",
    modules: "numba, scipy.sparse, sksparse.cholmod",
};

const COLLECTIONS: Environment = Environment {
    folder: "venv-collections",
    requirements: "requirements-collections.txt",
    modules: "trimesh, pygltflib, DracoPy, meshoptimizer, plyfile, tinyobjloader, pxr.Usd",
};

/// Makes the environment of the programs that meshes are compared with if it is missing. Returns its Python.
pub(crate) fn collections() -> Result<PathBuf> {
    COLLECTIONS.make()?;
    Ok(COLLECTIONS.python())
}

/// Makes the environment that has Blender if it is missing. Returns its Python.
pub(crate) fn blender() -> Result<PathBuf> {
    ENVIRONMENTS[2].make()?;
    Ok(ENVIRONMENTS[2].python())
}

/// Makes the environment of the programs that open exports if it is missing. Returns its Python.
pub(crate) fn clients() -> Result<PathBuf> {
    ENVIRONMENTS[3].make()?;
    Ok(ENVIRONMENTS[3].python())
}

/// Makes the environment of the Python package's tests if it is missing. Returns its Python.
pub(crate) fn package() -> Result<PathBuf> {
    ENVIRONMENTS[4].make()?;
    Ok(ENVIRONMENTS[4].python())
}

/// Makes the environments of all Blenders that exports are opened with. Returns their Pythons, the oldest
/// first.
pub(crate) fn blenders() -> Result<Vec<PathBuf>> {
    BLENDERS.iter().try_for_each(Environment::make)?;
    Ok(BLENDERS.iter().map(Environment::python).chain([blender()?]).collect())
}

/// Makes the environment of the bench's peers if it is missing. Returns its Python.
pub(crate) fn peers() -> Result<PathBuf> {
    PEERS.make()?;
    Ok(PEERS.python())
}

/// Makes the environment that has NumPy if it is missing. Returns its Python.
pub(crate) fn numpy() -> Result<PathBuf> {
    ENVIRONMENTS[0].make()?;
    Ok(ENVIRONMENTS[0].python())
}

/// Makes each environment of the tests that is missing or has other packages than its file lists.
pub(crate) fn python_packages() -> Result {
    ENVIRONMENTS.iter().chain(&BLENDERS).try_for_each(Environment::make)
}

impl Environment {
    fn path(&self) -> PathBuf {
        root().join("target").join(self.folder)
    }

    fn python(&self) -> PathBuf {
        self.path().join("bin/python")
    }

    fn make(&self) -> Result {
        let (venv, python) = (self.path(), self.python());
        let wanted = root().join("xtask").join(self.requirements);
        // Written last, so that it stands for a finished installation.
        let installed = venv.join("requirements.txt");
        let import = format!("import {}", self.modules);
        if same_text(&wanted, &installed) && succeeds(command(&python, &["-c", &import])) {
            return Ok(());
        }
        // A folder from another Python or an interrupted run is of no use.
        let mut make_venv = command(interpreter()?, &["-m", "venv", "--clear"]);
        make_venv.arg(&venv);
        run(make_venv)?;
        let mut install =
            command(&python, &["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        install.arg("--requirement").arg(&wanted);
        run(install).map_err(|e| {
            format!("{e}: the packages of xtask/{} could not be installed", self.requirements)
        })?;
        run(command(&python, &["-c", &import])).map_err(|e| {
            format!("{e}: what xtask/{} names is installed and does not start", self.requirements)
        })?;
        copy(&wanted, &installed)
    }
}

/// The command that starts the Python version of the packages.
fn interpreter() -> Result<&'static str> {
    let version = |program: &str| {
        let print = "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])";
        output(command(program, &["-c", print]))
    };
    if let Some(program) =
        ["python3.11", "python3"].into_iter().find(|p| version(p).as_deref() == Some(PYTHON))
    {
        return Ok(program);
    }
    let found = version("python3").map_or("no python3".into(), |version| format!("Python {version}"));
    Err(format!(
        "the Python packages need Python {PYTHON}, the only one that Blender's module bpy 5.0.1 is made for, and there is \
         {found}: install it, with venv, so that `python{PYTHON}` is in the PATH, then try again"
    ))
}
