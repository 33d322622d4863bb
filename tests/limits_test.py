# SPDX-License-Identifier: Apache-2.0
"""limits.py must name all that is beyond a limit, and nothing else."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import limits

SPDX = "// SPDX-License-Identifier: Apache-2.0\n"
HEAD = SPDX + "// What it is for.\n\n#pragma once\n"


def body(lines, outline="  // counts up\n"):
    """A function of so many lines, of which one outlines it."""
    return "int f(int x) {\n" + (outline or "  ++x;\n") + "  ++x;\n" * (lines - 4) + "  return x;\n}\n"


class Limits(unittest.TestCase):
    """Trees with one file each."""

    def complaints(self, text, name="core/a.cpp", allowed=""):
        with tempfile.TemporaryDirectory() as folder:
            for path, content in ((name, text), ("tests/limits.txt", allowed)):
                Path(folder, path).parent.mkdir(exist_ok=True)
                Path(folder, path).write_text(content)
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                failed = limits.main(folder)
            *complaints, _ = said.getvalue().splitlines()
            self.assertEqual(failed, bool(complaints))
            return complaints

    def test_what_is_just_below_a_limit_passes(self):
        self.assertEqual(self.complaints(SPDX + body(39)), [])
        self.assertEqual(self.complaints(SPDX + "\n" * 398), [])
        self.assertEqual(self.complaints(HEAD + "\n" * 145, "core/a.hpp"), [])
        self.assertEqual(self.complaints("\n" * 399, "docs/a.py"), [])
        self.assertEqual(self.complaints("\n" * 500, "build/a.cpp"), [])

    def test_what_is_at_a_limit_is_named_with_its_number(self):
        self.assertEqual(self.complaints(SPDX + body(40)), ["core/a.cpp:f: 40 lines, 39 are allowed"])
        self.assertEqual(self.complaints(SPDX + "\n" * 399), ["core/a.cpp: 400 lines, 399 are allowed"])
        self.assertEqual(self.complaints(SPDX + "\n" * 399, "core/a.cu"),
                         ["core/a.cu: 400 lines, 399 are allowed"])
        for name in ("core/a.hpp", "core/a.cuh"):
            self.assertEqual(self.complaints(HEAD + "\n" * 146, name),
                             [f"{name}: 150 lines, 149 are allowed"])
        self.assertEqual(self.complaints("\n" * 400, "docs/a.py"), ["docs/a.py: 400 lines, 399 are allowed"])

    def test_a_long_function_has_an_outline(self):
        self.assertEqual(self.complaints(SPDX + body(24, "")), [])
        self.assertEqual(self.complaints(SPDX + body(25)), [])
        for no_outline in ("", "  ++x;  // beside\n"):
            self.assertEqual(self.complaints(SPDX + body(25, no_outline)),
                             ["core/a.cpp:f: 25 lines without a comment that outlines them"])

    def test_a_file_begins_with_its_licence_and_a_header_with_its_purpose(self):
        self.assertEqual(len(self.complaints("int x;\n")), 1)
        self.assertEqual(len(self.complaints(SPDX + "#pragma once\n", "core/a.hpp")), 1)

    def test_exceptions_are_as_large_as_needed_and_needed(self):
        text = SPDX + body(50)
        self.assertEqual(self.complaints(text, allowed="# why\n50 core/a.cpp:f a table\n"), [])
        self.assertEqual(self.complaints(text, allowed="49 core/a.cpp:f a table\n"),
                         ["core/a.cpp:f: 50 lines, 49 are allowed"])
        for name in ("core/a.cpp:g", "core/a.cpp", "core/b.cpp"):
            said = self.complaints(text, allowed=f"50 core/a.cpp:f a table\n500 {name} gone\n")
            self.assertEqual(said, [f"{name}: needs no exception any more; take it out of tests/limits.txt"])

    def test_braces_that_do_not_match_are_said(self):
        for text in ("void f() {\n", "}\n"):
            self.assertEqual(len(self.complaints(SPDX + text)), 1)


class Functions(unittest.TestCase):
    """What has a body and how long it is."""

    def found(self, text):
        return [(name, last - first + 1) for name, first, last in limits.functions(text)]

    def test_names_are_those_of_the_definition(self):
        cases = {
            "int f() {\n}\n": [("f", 2)],
            "template <class T, class = std::enable_if_t<std::is_same_v<T, int>>>\nT f(T x)\n    noexcept {\n}\n":
                [("f", 3)],
            "A::A(int x)\n    : B{x}, c_(x), d_{1} {\n}\n": [("A::A", 3)],
            "template <class T>\nvoid A<T>::f() const {\n}\n": [("A::f", 2)],
            "bool A::operator==(const A& a) const {\n}\n": [("A::operator==", 2)],
            "int A::operator()(int x) {\n}\n": [("A::operator()", 2)],
            "auto f(int x) -> std::vector<int> {\n}\n": [("f", 2)],
            "const auto f = [](int x) {\n};\n": [("f", 2)],
            "TEST(Suite, Name) {\n}\n": [("Suite.Name", 2)],
            "__global__ void __launch_bounds__(kWide(2)) k(int x) {\n}\n": [("k", 2)],
            "namespace a::b {\nnamespace {\nint f() {\n  return 1;\n}\n}\n}\n": [("f", 3)],
            'extern "C" {\nint f() {\n}\n}\n': [("f", 2)],
            "struct alignas(16) A : B<int> {\n  int x{1};\n  int f() { return 1; }\n  struct C {\n    C() {}\n  };\n"
            "};\nint g() {\n}\n": [("f", 1), ("C", 1), ("g", 2)],
        }
        for text, expected in cases.items():
            self.assertEqual(self.found(text), expected, text)

    def test_other_braces_are_no_functions(self):
        for text in ("int x{1};\n", "int x[] = {1, 2};\n", "enum class A : int { kB, kC };\n", "struct A {};\n",
                     "constexpr auto a = f(1, {2});\n", "const std::map<int, A> m = {{1, A{}}};\n"):
            self.assertEqual(self.found(text), [], text)

    def test_braces_in_texts_comments_and_macros_do_not_count(self):
        self.assertEqual(self.found('void f() {\n  g("{", \'{\', 1\'000);  // {\n  /* { */\n  h(R"x({)" {)x");\n}\n'),
                         [("f", 5)])
        self.assertEqual(self.found("#define F(x) \\\n  if (x) {\nvoid f() {\n}\n"), [("f", 2)])

    def test_what_is_inside_a_function_belongs_to_it(self):
        self.assertEqual(self.found("void f() {\n  struct A {\n    void g() {}\n  };\n  run([] {\n    h();\n  });\n}\n"),
                         [("f", 8)])


if __name__ == "__main__":
    unittest.main()
