"""Sections of the configuration: those of a job, those that a network changes, and settings that two of them make."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar, cast

from pydantic import BaseModel, TypeAdapter

from repro.cnn.dataset import DataSettings
from repro.config.check import merged
from repro.config.model import Configuration
from repro.identification.algorithm1.search import SearchSettings

S = TypeVar("S")


def job_configuration(sections: Mapping[str, Any], checkpoint_every: int) -> Configuration:
    """A job's configuration: it has the sections that its rule names, with the keys that they name there."""
    config = cast(Configuration, _built(Configuration, sections))
    return changed(config, {"training": {"checkpoint_every": checkpoint_every}} if "training" in sections else {})


def _built(kind: Any, content: Any) -> Any:  # noqa: ANN401
    """A value of a key; a section without a class of its own may lack keys, which then cannot be read."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        kinds = {name: field.annotation for name, field in kind.model_fields.items()}
        names = {field.alias or name: name for name, field in kind.model_fields.items()}
        given = {names[key]: _built(kinds[names[key]], value) for key, value in content.items()}
        return kind.model_construct(**given)
    return TypeAdapter(kind).validate_python(content)


def changed(section: S, overlay: Mapping[str, Any]) -> S:
    """A configuration or a section of it with other values."""
    if isinstance(section, Mapping):  # a network's changes
        return cast(S, merged(section, overlay))
    names = {field.alias or name: name for name, field in getattr(type(section), "model_fields", {}).items()}
    values = {}
    for key, value in overlay.items():
        now = getattr(section, names.get(key, key))
        nested = changed(now, value) if isinstance(value, Mapping) else value
        values[names.get(key, key)] = tuple(nested) if isinstance(now, tuple) else nested  # as lists of YAML are read
    made = (
        section.model_copy(update=values) if isinstance(section, BaseModel) else replace(cast(Any, section), **values)
    )
    return cast(S, made)


def of_network(config: Configuration, network: str) -> Configuration:
    """Configuration as a network changes it, from section ``networks``; the published one changes nothing."""
    return changed(config, {} if network == "published" else plain(config.networks)[network])


def plain(section: BaseModel) -> dict[str, Any]:
    """Sections as mappings, with the keys of the files."""
    return section.model_dump(by_alias=True, exclude_unset=True)


def stated(config: Configuration, *sections: str) -> dict[str, Any]:
    """These sections as mappings, without the keys that are at the default of their class."""
    return {name: _stated(getattr(config, name)) for name in sections}


def _stated(section: Any) -> Any:  # noqa: ANN401
    if isinstance(section, BaseModel):
        given = {field.alias or name: name for name, field in type(section).model_fields.items()}
        return {key: _stated(getattr(section, name)) for key, name in given.items() if name in section.model_fields_set}
    if not is_dataclass(section):
        return section
    values = {field.name: (getattr(section, field.name), field.default) for field in fields(section)}
    return {name: _stated(value) for name, (value, default) in values.items() if value != default}


def data_settings(config: Configuration) -> DataSettings:
    """Distribution of training samples, from sections ``data`` and ``image``."""
    own = {field.name: getattr(config.data, field.name) for field in fields(DataSettings) if field.name != "image"}
    return DataSettings(**own, image=config.image)


def search_settings(config: Configuration) -> SearchSettings:
    """Constants of Algorithm 1 with the formulas of similarity, from sections ``algorithm1`` and ``metric``."""
    return SearchSettings(**vars(config.algorithm1), metric=config.metric)
