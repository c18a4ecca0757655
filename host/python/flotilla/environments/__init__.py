"""Learning environments over the simulation of `flotilla run`; an action is one cycle of the modules.

`FlotillaEnv` is Gymnasium's, of one structure; `FlotillaVectorEnv` a batch of it, stepped in Rust on all cores; `FlotillaParallelEnv`
PettingZoo's, with one agent a module. Gymnasium knows `Flotilla/Velocity-v0` and `Flotilla/Station-v0` once this is imported.
`pip install flotilla[environments]` brings both packages.
"""

from gymnasium import register, registry

from .parallel import FlotillaParallelEnv
from .single import FlotillaEnv
from .vector import FlotillaVectorEnv

__all__ = ["FlotillaEnv", "FlotillaParallelEnv", "FlotillaVectorEnv"]

for _task in ("velocity", "station"):
    if (_name := f"Flotilla/{_task.capitalize()}-v0") not in registry:
        register(
            id=_name,
            entry_point="flotilla.environments:FlotillaEnv",
            vector_entry_point="flotilla.environments:FlotillaVectorEnv",
            kwargs={"task": _task},
        )
