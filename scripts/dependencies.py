#!/usr/bin/env python3
"""What cargo-deny checks of licences, bans and sources, where it is not installed: `cargo metadata … | dependencies.py`.

It reads the lists of deny.toml, and looks at the dependencies of this system. Known holes it cannot tell: their database
comes from the network."""

import json
import re
import sys
import tomllib

REGISTRY = "registry+https://github.com/rust-lang/crates.io-index"


def is_allowed(expression, allowed):
    """Whether an SPDX expression can be met by licences that are allowed. Old crates say "MIT/Apache-2.0"."""
    words = re.findall(r"[()]|[^\s()]+", expression.replace("/", " OR "))

    def either():
        met = both()
        while words and words[0] == "OR":
            words.pop(0)
            met = both() or met
        return met

    def both():
        met = one()
        while words and words[0] == "AND":
            words.pop(0)
            met = one() and met
        return met

    def one():
        word = words.pop(0)
        if word == "(":
            met = either()
            words.pop(0)
            return met
        if words and words[0] == "WITH":
            words.pop(0)
            word += " WITH " + words.pop(0)
        return word in allowed

    return either()


def faults(metadata, rules):
    """One line for each dependency that breaks a rule."""
    allowed = set(rules["licenses"]["allow"])
    exceptions = {one["crate"]: set(one["allow"]) for one in rules["licenses"].get("exceptions", [])}
    clarified = {one["crate"]: one["expression"] for one in rules["licenses"].get("clarify", [])}
    banned = {ban["crate"]: ban["reason"] for ban in rules["bans"]["deny"]}
    resolved = {node["id"] for node in metadata["resolve"]["nodes"]}
    for package in (package for package in metadata["packages"] if package["id"] in resolved):
        name, source = f"{package['name']} {package['version']}", package["source"]
        if source is None:
            continue
        if source != REGISTRY:
            yield f"{name} comes from {source}"
        if package["name"] in banned:
            yield f"{name} is banned: {banned[package['name']]}"
        licence = package["license"] or clarified.get(package["name"])
        if not licence or not is_allowed(licence, allowed | exceptions.get(package["name"], set())):
            yield f"{name} is under {licence or 'a licence of its own'}"


def main():
    with open("deny.toml", "rb") as file:
        rules = tomllib.load(file)
    found = list(faults(json.load(sys.stdin), rules))
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
