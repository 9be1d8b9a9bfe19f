# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about the manual's pages, what shells complete, and the version.
Run as: manual_test.py PLUMB"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(*command, accept=(0,), **how):
    result = subprocess.run(command, **how, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            check=False)
    if result.returncode not in accept:
        raise AssertionError(f"{command}: {result.returncode}\n{result.stdout}")
    return result.stdout


def options_in(text):
    """As the help lists them: "  -o,--output FILE"."""
    lines = re.findall(r"^  (-[\w,-]+)", text, re.MULTILINE)
    return {name for line in lines for name in line.split(",")}


class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        run(PLUMB, "manual", cls.folder, cwd=ROOT)
        listed = run(PLUMB, "--help").split("Subcommands:")[1].split("Example")[0]
        cls.commands = re.findall(r"^  (\w+)", listed, re.MULTILINE)
        cls.options = {name: options_in(run(PLUMB, name, "--help")) for name in cls.commands}

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def complete(self, *words):
        """What bash offers for the last word."""
        typed = " ".join(f"'{word}'" for word in words)
        script = (f"cd '{self.folder}/man'; source ../bash-completion/completions/plumb;"
                  f"COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; compopt() {{ :; }};"
                  "_plumb; printf '%s\\n' \"${COMPREPLY[@]}\"")
        return run("bash", "-c", script).split()

    def test_every_command_has_a_page_with_all_its_options(self):
        self.assertGreater(len(self.commands), 10)
        for command, options in self.options.items():
            page = (self.folder / "man" / "man1" / f"plumb-{command}.1").read_text("utf-8")
            named = set(re.findall(r"\\fB(-[\w-]+)\\fR", page.replace("\\-", "-")))
            self.assertEqual(named, options, command)
            self.assertIn(".SH EXIT STATUS", page, command)
        page = (self.folder / "man" / "man1" / "plumb.1").read_text("utf-8")
        for command in self.commands:
            self.assertIn(f"plumb\\-{command}\\fR(1)", page)

    def test_bash_offers_commands_and_all_their_options(self):
        self.assertEqual(set(self.complete("plumb", "")) - set(self.complete("plumb", "-")),
                         set(self.commands))
        for command, options in self.options.items():
            self.assertEqual(set(self.complete("plumb", command, "-")), options, command)

    def test_bash_offers_the_words_that_an_option_takes_else_files(self):
        methods = ["bsdf", "nee", "mis", "plain"]
        self.assertEqual(self.complete("plumb", "render", "--method", ""), methods)
        self.assertEqual(self.complete("plumb", "render", "--method", "=", "b"), ["bsdf"])
        self.assertEqual(self.complete("plumb", "converge", "--methods", "nee,b"), ["nee,bsdf"])
        self.assertIn("inverse-pi", self.complete("plumb", "render", "--fault", "i"))
        self.assertEqual(self.complete("plumb", "reference", "--with", "c"), ["cycles"])
        self.assertEqual(self.complete("plumb", "reference", "--with", "m"), ["mitsuba", "man1"])
        self.assertEqual(self.complete("plumb", "stress", "--methods", "mis,"),
                         [f"mis,{word}" for word in [*methods, "default", "radiosity"]])
        self.assertEqual(self.complete("plumb", "stress", "--with", "mitsuba,c"), ["mitsuba,cycles"])
        self.assertEqual(self.complete("plumb", "converge", "--with", "p"), ["povray"])
        self.assertEqual(self.complete("plumb", "export", "--to", "").count("json"), 1)
        self.assertEqual(self.complete("plumb", "export", "--to", "mi"), [])
        self.assertIn("inverse-pi", self.complete("plumb", "power", "--fault", "i"))
        self.assertEqual(self.complete("plumb", "stress", "--scene", "slit,caustic_"), ["slit,caustic_in_mirror"])
        self.assertEqual(self.complete("plumb", "certify", "--scene", "03"), ["03_tilted_lamp"])
        self.assertIn("cornell/2:2", self.complete("plumb", "certify", "--scene", "corn"))
        self.assertEqual(self.complete("plumb", "render", "--precision", ""), ["float", "double"])
        for command, option in (("reference", "--with"), ("certify", "--with"), ("stress", "--with")):
            self.assertNotIn("FILE.toml", self.complete("plumb", command, option, ""), command)
        self.assertEqual(self.complete("plumb", "render", ""), ["man1"])
        self.assertEqual(self.complete("plumb", "render", "--spp", ""), [])

    def test_other_shells_know_all_options_too(self):
        zsh = (self.folder / "zsh/site-functions/_plumb").read_text("utf-8")
        fish = (self.folder / "fish/vendor_completions.d/plumb.fish").read_text("utf-8")
        for command, options in self.options.items():
            of_zsh = zsh.split(f"\n    {command}) ")[1].split(";;")[0]
            self.assertEqual(set(re.findall(r"^ +'\*?(-[\w-]+)\[", of_zsh, re.MULTILINE)), options)
            lines = [line for line in fish.splitlines() if f"_from {command}'" in line]
            of_fish = {"-" * len(dashes) + name for line in lines
                       for dashes, name in re.findall(r" -(l|s) ([\w-]+)", line)}
            wanted = {re.sub("^-+", "-", name) for name in options}
            self.assertEqual(of_fish, wanted, command)
        self.assertIn(":(bsdf nee mis plain)'", zsh)
        self.assertIn(" -a 'bsdf nee mis plain'", fish)
        self.assertIn(":_sequence compadd - bsdf nee mis plain'", zsh)
        self.assertIn(" -a '(__fish_append , bsdf nee mis plain)'", fish)
        self.assertIn(":{compadd - povray cycles mitsuba; _files}'", zsh)

    def test_versions_agree(self):
        version = re.search(r"^project\(plumbline VERSION (\S+)",
                            (ROOT / "CMakeLists.txt").read_text("utf-8"), re.MULTILINE)[1]
        self.assertEqual(run(PLUMB, "--version"), f"plumb {version}\n")
        self.assertIn(f"\nversion: {version}\n", (ROOT / "CITATION.cff").read_text("utf-8"))
        for page in (self.folder / "man" / "man1").iterdir():
            self.assertIn(f'"Plumbline {version}"', page.read_text("utf-8"))

    def test_a_bug_report_says_what_runs_where(self):
        said = run(PLUMB, "--verbose", "--version")
        for line in ("commit", "compiler", "processor", "system", "libraries", "scenes", "povray",
                     "cycles", "mitsuba"):
            self.assertRegex(said, rf"(?m)^{line} +\S")
        self.assertIn("--verbose requires --version", run(PLUMB, "--verbose", accept=(2,)))


if __name__ == "__main__":
    PLUMB = sys.argv[1]
    unittest.main(argv=sys.argv[:1])
