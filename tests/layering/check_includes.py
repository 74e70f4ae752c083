"""Checks that each public header includes what it names of the standard library and of GLM.

Sources are compiled many at once, behind shared precompiled headers: a missing include would show
in a user's build only. Usage: check_includes.py SOURCE_FOLDER FOLDER...
"""

import pathlib
import re
import sys

# A name of std:: and the headers that may declare it for a reader.
STANDARD = {
    "array": "array",
    "vector": "vector",
    "string": "string",
    "to_string": "string",
    "string_view": "string_view",
    "span": "span",
    "optional": "optional",
    "nullopt": "optional",
    "variant": "variant",
    "monostate": "variant",
    "map": "map",
    "multimap": "map",
    "set": "set",
    "unordered_map": "unordered_map",
    "unordered_set": "unordered_set",
    "deque": "deque",
    "list": "list",
    "tuple": "tuple",
    "function": "functional",
    "unique_ptr": "memory",
    "shared_ptr": "memory",
    "weak_ptr": "memory",
    "make_unique": "memory",
    "make_shared": "memory",
    "pair": "utility",
    "move": "utility",
    "forward": "utility",
    "exchange": "utility",
    "swap": "utility",
    "size_t": "cstddef",
    "ptrdiff_t": "cstddef",
    "byte": "cstddef",
    "numeric_limits": "limits",
    "complex": "complex",
    "filesystem": "filesystem",
    "chrono": "chrono",
    "thread": "thread",
    "jthread": "thread",
    "stop_token": "stop_token",
    "stop_source": "stop_token",
    "mutex": "mutex",
    "lock_guard": "mutex",
    "unique_lock": "mutex",
    "condition_variable": "condition_variable",
    "condition_variable_any": "condition_variable",
    "future": "future",
    "promise": "future",
    "atomic": "atomic",
    "runtime_error": "stdexcept",
    "logic_error": "stdexcept",
    "invalid_argument": "stdexcept",
    "out_of_range": "stdexcept",
    "exception": "exception",
    "exception_ptr": "exception",
    "ostream": "iosfwd ostream iostream sstream fstream",
    "istream": "iosfwd istream iostream sstream fstream",
    "ofstream": "fstream",
    "ifstream": "fstream",
    "min": "algorithm",
    "max": "algorithm",
    "clamp": "algorithm",
    "sort": "algorithm",
    "lower_bound": "algorithm",
    "upper_bound": "algorithm",
    "nth_element": "algorithm",
    "fill": "algorithm",
    "copy": "algorithm",
    "find": "algorithm",
    "find_if": "algorithm",
    "any_of": "algorithm",
    "all_of": "algorithm",
    "accumulate": "numeric",
    "iota": "numeric",
    "sqrt": "cmath",
    "pow": "cmath",
    "exp": "cmath",
    "log": "cmath",
    "sin": "cmath",
    "cos": "cmath",
    "abs": "cmath cstdlib",
    "hypot": "cmath",
    "atan2": "cmath",
    "floor": "cmath",
    "lround": "cmath",
    "isfinite": "cmath",
    "is_same_v": "type_traits",
    "decay_t": "type_traits",
    "invoke_result_t": "type_traits",
    **{f"{sign}int{bits}_t": "cstdint" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}
GLM = {
    **{f"{kind}vec{n}": f"glm/vec{n}.hpp" for kind in ("", "d", "i", "u", "b") for n in (2, 3, 4)},
    **{f"{kind}mat{n}": f"glm/mat{n}x{n}.hpp" for kind in ("", "d") for n in (2, 3, 4)},
    "dquat": "glm/gtc/quaternion.hpp",
    "quat": "glm/gtc/quaternion.hpp",
    **{name: "glm/geometric.hpp" for name in ("dot", "cross", "length", "normalize", "distance")},
}
COMMENTS_AND_TEXTS = re.compile(r'//[^\n]*|/\*.*?\*/|R"\(.*?\)"|"(?:\\.|[^"\\\n])*"', re.DOTALL)
NAMES = re.compile(r"\b(std|glm)::([a-z_0-9]+)")
INCLUDE = re.compile(r"^#include <([^>]+)>", re.MULTILINE)


def missing(text):
    """Returns the names that a header's text uses without their headers, and these."""
    included = set(INCLUDE.findall(text))
    lacking = {}
    for library, name in NAMES.findall(COMMENTS_AND_TEXTS.sub(" ", text)):
        headers = (STANDARD if library == "std" else GLM).get(name)
        if headers and not included.intersection(headers.split()):
            lacking[f"{library}::{name}"] = headers.split()[0]
    return lacking


def main():
    source = pathlib.Path(sys.argv[1])
    if missing("std::vector<int> a;  // std::map\n") != {"std::vector": "vector"}:
        sys.exit("check_includes.py: does not find what is missing")
    headers = [
        header
        for folder in sys.argv[2:]
        for header in sorted((source / folder).rglob("*.h"))
        if "internal" not in header.parts
    ]
    if not headers:
        sys.exit("check_includes.py: no header found")
    faults = 0
    for header in headers:
        for name, wanted in missing(header.read_text()).items():
            faults += 1
            print(f"{header.relative_to(source)}: {name}: expected #include <{wanted}>")
    print(f"{len(headers)} headers, {faults} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
