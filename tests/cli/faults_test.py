#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What happens to files when a run is stopped, or the system refuses an operation in the middle.

    faults_test.py PATH_OF_ESPALIER [LIBRARY_THAT_LETS_ALLOCATIONS_FAIL LIBRARY_THAT_SENDS_SIGNALS]
"""

import os
import pty
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import unittest

import program
from program import CliTest, icosphere_points

CLEAR_LINE = "\r\x1b[K"
NOBODY = 65534
FAILING_PRELOAD = SIGNAL_PRELOAD = ""


class FaultsTest(CliTest):
    def setUp(self):
        super().setUp()
        self.run_program("shape", "box", "--cells", 4, 4, 4, "-o", "rest.vtu", "--quiet")

    def contents(self):
        """Returns the files in the folder by path, with their bytes; None for folders and unreadable files."""
        return {path: path.read_bytes() if path.is_file() and os.access(path, os.R_OK) else None
                for path in self.path.rglob("*")}

    def start(self, *arguments, **options):
        return subprocess.Popen([program.ESPALIER, *map(str, arguments)], cwd=self.path,
                                **options)

    def assert_fails(self, cause, *arguments, **options):
        """Checks exit code 1, this one line (a text or a compiled pattern), and that no file has
        changed."""
        before = self.contents()
        options = {"stdout": subprocess.PIPE, **options}
        process = self.start(*arguments, stderr=subprocess.PIPE, text=True, **options)
        _, error = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1, error)
        pattern = cause if isinstance(cause, str) else cause.pattern
        self.assertRegex(error, rf"^espalier: {re.escape(cause) if pattern is cause else pattern}\n$")
        self.assertEqual(self.contents(), before)


class OnATerminal(FaultsTest):
    """Runs on a terminal, where the program shows its stage."""

    def setUp(self):
        super().setUp()
        # At level 6 of irregular cells, one thread binds for some tenths of a second: much longer than this process
        # waits for a core.
        self.run_program("shape", "cylinder", "--sectors", 3, "--from", 0.5, 0.5, -0.5, "--to", 0.5, 0.5, 1.5,
                         "-o", "rest.vtu", "--quiet")
        self.write_model(icosphere_points(20000))
        self.put("m.espb", "old")
        # A test in the background may have inherited ignored signals.
        for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]:
            self.handle(number, signal.SIG_DFL)

    def handle(self, number, handler):
        """Sets a handler in this process and in its children, until the test ends."""
        self.addCleanup(signal.signal, number, signal.signal(number, handler))

    def bind_until(self, stage, then, output="m.espb", level=6):
        """Returns the signal that killed the program, or its exit code, and the text on the terminal."""
        master, slave = pty.openpty()
        process = self.start("bind", "model.obj", "--rest", "rest.vtu", "-n", level, "--threads", 1,
                             "-o", output, stdout=subprocess.DEVNULL, stderr=slave)
        os.close(slave)
        screen = ""
        try:
            while data := os.read(master, 4096):
                screen += data.decode()
                if stage and f"{stage} ..." in screen:
                    then(process)
                    stage = None
        except OSError:
            pass  # the other end is closed
        finally:
            os.close(master)
        return process.wait(timeout=120), screen

    def test_a_signal_while_binding_leaves_nothing_behind(self):
        before = self.contents()
        for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL]:
            code, screen = self.bind_until("binding", lambda it: it.send_signal(number))
            self.assertEqual(code, -number)
            self.assertEqual(self.contents(), before)
            if number != signal.SIGKILL:
                self.assertTrue(screen.endswith(CLEAR_LINE), repr(screen))

    def test_a_signal_while_writing_leaves_the_old_file_or_the_new_one(self):
        self.run_program("bind", "model.obj", "--rest", "rest.vtu", "-n", 2, "-o", "whole.espb")
        whole = self.bytes("whole.espb")
        before = self.contents()
        for number in [signal.SIGINT, signal.SIGTERM, signal.SIGKILL]:
            self.put("m.espb", "old")
            code, _ = self.bind_until("writing", lambda it: it.send_signal(number), level=2)
            self.assertIn(code, [-number, 0])
            after = self.contents()
            self.assertEqual(after.keys(), before.keys())
            self.assertIn(after[self.path / "m.espb"], [b"old", whole])
            if code == 0:
                self.assertEqual(after[self.path / "m.espb"], whole)

    def test_a_folder_that_is_removed_while_binding(self):
        (self.path / "out").mkdir()
        code, screen = self.bind_until("binding", lambda _: shutil.rmtree(self.path / "out"),
                                       output="out/m.espb")
        self.assertEqual(code, 1)
        self.assertTrue(screen.endswith(
            CLEAR_LINE + "espalier: out/m.espb: cannot create a file beside it: "
            "No such file or directory\r\n"), repr(screen))

    def test_signals_that_are_ignored_stay_so(self):
        self.handle(signal.SIGHUP, signal.SIG_IGN)
        code, _ = self.bind_until("binding", lambda it: it.send_signal(signal.SIGHUP))
        self.assertEqual(code, 0)

    def test_a_terminal_that_goes_away(self):
        master, slave = pty.openpty()
        self.handle(signal.SIGHUP, signal.SIG_IGN)  # as nohup has it
        process = self.start("bind", "model.obj", "--rest", "rest.vtu", "-n", 2, "-o", "m.espb",
                             stdout=subprocess.DEVNULL, stderr=slave)
        os.close(slave)
        os.read(master, 1)
        os.close(master)
        self.assertEqual(process.wait(timeout=120), 0)
        self.assertNotEqual(self.bytes("m.espb"), b"old")


class Signals(FaultsTest):
    """After a signal that can be blocked, there are only the files from before and the outputs."""

    def setUp(self):
        super().setUp()
        # The matrix has several files, and there are enough points to keep the threads busy.
        self.write_model(icosphere_points(2000))
        self.stencils = ["stencils", "rest.vtu", "--points", "model.obj", "-n", 2, "-o", "m.npy",
                         "--quiet"]
        self.run_program(*self.stencils)
        self.files = self.contents()
        self.handle_default()
        # SIGQUIT must not leave a core file here.
        cores = resource.getrlimit(resource.RLIMIT_CORE)
        resource.setrlimit(resource.RLIMIT_CORE, (0, cores[1]))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_CORE, cores)

    def handle_default(self):
        # A test in the background may have inherited ignored signals.
        for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]:
            self.addCleanup(signal.signal, number, signal.signal(number, signal.SIG_DFL))

    def assert_files_are_whole(self):
        after = self.contents()
        self.assertEqual(after.keys(), self.files.keys())
        changed = [path.name for path in after if after[path] != self.files[path]]
        self.assertEqual(changed, [])

    def test_one_that_comes_at_any_time(self):
        start = time.monotonic()
        self.run_program(*self.stencils)
        seconds = time.monotonic() - start
        random.seed(20)
        for _ in range(40):
            process = self.start(*self.stencils)
            time.sleep(random.uniform(0.2, 1.05) * seconds)
            process.send_signal(signal.SIGTERM)
            self.assertIn(process.wait(timeout=120), [-signal.SIGTERM, 0])
            self.assert_files_are_whole()

    def test_one_that_comes_when_files_are_renamed(self):
        if not SIGNAL_PRELOAD:
            self.skipTest("without the library for it")
        for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]:
            for path in self.path.glob("m*.npy"):
                path.unlink()
            process = self.start(*self.stencils, env={**os.environ, "LD_PRELOAD": SIGNAL_PRELOAD,
                                                      "ESPALIER_TEST_SIGNAL": str(int(number))})
            self.assertEqual(process.wait(timeout=120), -number)
            self.assert_files_are_whole()


class Files(FaultsTest):
    def setUp(self):
        super().setUp()
        self.write_model(icosphere_points(500))
        self.put("m.espb", "old")

    def bind(self, output="m.espb"):
        return ["bind", "model.obj", "--rest", "rest.vtu", "-n", 2, "-o", output]

    def as_nobody(self):
        """Returns how to start the program as a user without all rights."""
        if os.geteuid() != 0:
            return {}
        who = {"user": NOBODY, "group": NOBODY, "extra_groups": []}
        try:
            subprocess.run([program.ESPALIER, "--version"], check=True, capture_output=True, **who)
        except (OSError, subprocess.CalledProcessError):
            self.skipTest("nobody may run the program where it is")
        return who

    def test_what_is_read_only_is_refused_before_any_work(self):
        who = self.as_nobody()
        self.path.chmod(0o777)
        (self.path / "m.espb").chmod(0o444)
        (self.path / "out").mkdir(mode=0o555)
        # The model is not a valid file: nothing is read before the output is checked.
        self.put("model.obj", "nonsense")
        self.assert_fails("m.espb: cannot write: Permission denied", *self.bind(), **who)
        self.assert_fails("out/m.espb: cannot create a file beside it: Permission denied",
                          *self.bind("out/m.espb"), **who)
        for command in [["refine", "rest.vtu"], ["stencils", "rest.vtu"]]:
            output = "out/a.vtu" if command[0] == "refine" else "out/a.mtx"
            self.assert_fails(f"{output}: cannot create a file beside it: Permission denied",
                              *command, "-n", 1, "-o", output, **who)

    def test_with_one_thread_no_other_is_started(self):
        # At the end of a limit of threads, oneTBB may start threads, and ends the program if it cannot.
        who = self.as_nobody()
        self.path.chmod(0o777)
        process = self.start("refine", "rest.vtu", "-n", 3, "--threads", 1, "-o", "r.vtu", "--quiet", **who,
                             preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NPROC, (1, 1)))
        self.assertEqual(process.wait(timeout=120), 0)

    def test_what_may_not_be_read_is_named(self):
        who = self.as_nobody()
        self.path.chmod(0o777)
        (self.path / "rest.vtu").chmod(0)
        self.assert_fails("rest.vtu: cannot open: Permission denied", *self.bind("new.espb"),
                          **who)

    def test_an_input_that_goes_while_another_is_read(self):
        os.mkfifo(self.path / "slow.obj")
        text = self.text("model.obj")
        rest = self.bytes("rest.vtu")

        def with_model_after(change):
            process = self.start("bind", "slow.obj", "--rest", "rest.vtu", "-o", "m.espb",
                                 stderr=subprocess.PIPE, text=True)
            with open(self.path / "slow.obj", "w") as model:  # the program has begun to read it
                change()
                model.write(text)
            _, error = process.communicate(timeout=120)
            self.assertEqual(process.returncode, 1)
            self.assertEqual(self.text("m.espb"), "old")
            return error

        self.assertEqual(with_model_after((self.path / "rest.vtu").unlink),
                         "espalier: rest.vtu: cannot open: No such file or directory\n")
        (self.path / "rest.vtu").write_bytes(rest)
        error = with_model_after(lambda: os.truncate(self.path / "rest.vtu", len(rest) // 2))
        self.assertRegex(error, r"^espalier: rest.vtu:\d+: [^\n]*\n$")

    def test_a_pipe_that_stands_for_two_inputs(self):
        for extension in ("vtu", "obj"):
            os.mkfifo(self.path / f"pipe.{extension}")
            (self.path / f"link.{extension}").symlink_to(f"pipe.{extension}")
        self.run_program("bind", "model.obj", "--rest", "rest.vtu", "-n", 1, "-o", "bound.espb")
        (self.path / "link.txt").symlink_to("pipe.obj")
        two = ["pipe.vtu", "link.vtu"]
        rest = ["--rest", "pipe.vtu"]
        output = ["-o", "out.obj"]
        alias = " (also called pipe.{})".format
        for name, given, command in [
                ("pipe.vtu", "for --rest and for --to",
                 ["deform", "model.obj", *rest, "--to", "pipe.vtu", *output]),
                ("link.vtu", "twice for --to" + alias("vtu"),
                 ["deform", "model.obj", "--rest", "rest.vtu", "--to", *two, "-o", "out%04d.obj"]),
                ("pipe.vtu", "for MODEL and for --rest (also called link.vtu)",
                 ["deform", "link.vtu", *rest, "--to", "rest.vtu", *output]),
                ("pipe.vtu", "for MODEL and for --rest (also called link.vtu)",
                 ["bind", "link.vtu", *rest, "-o", "out.espb"]),
                ("link.vtu", "twice for --to" + alias("vtu"),
                 ["apply", "bound.espb", "--to", *two, "-o", "out%04d.obj"]),
                ("link.obj", "for MODEL and for --targets" + alias("obj"),
                 ["fit", "pipe.obj", "--rest", "rest.vtu", "--targets", "link.obj", "-o",
                  "out.vtu"]),
                ("link.txt", "for MODEL and for --targets" + alias("obj"),
                 ["fit", "pipe.obj", "--rest", "rest.vtu", "--targets", "link.txt", "-o",
                  "out.vtu"]),
                ("pipe.vtu", "for LATTICE and for --rest (also called link.vtu)",
                 ["check", "link.vtu", *rest]),
                ("link.vtu", "twice for FILE" + alias("vtu"), ["compare", *two]),
                ("link.vtu", "for LATTICE and for --points" + alias("vtu"),
                 ["stencils", "pipe.vtu", "--points", "link.vtu", "-o", "out.mtx"]),
                ("pipe.vtu", "for MODEL and for --rest (also called link.vtu)",
                 ["bench", "link.vtu", *rest]),
                ("link.vtu", "twice for MODEL" + alias("vtu"),
                 ["shape", "around", *two, "-o", "out.ovm"]),
                ("link.vtu", "twice for LATTICE" + alias("vtu"),
                 ["shape", "merge", *two, "-o", "out.vtu"])]:
            if command[0] == "compare" and "--html" not in self.run_program("compare", "--help").stdout:
                continue
            self.assert_fails(f"{name}: is given {given}, but can be read only once, since it is not "
                              "a regular file; copy it to a file first", *command)

    def test_a_pipe_that_stands_for_an_input_and_an_output(self):
        os.mkfifo(self.path / "pipe.obj")
        (self.path / "link.obj").symlink_to("pipe.obj")
        self.assert_fails("link.obj: is also an input (MODEL), and would be overwritten; choose "
                          "another name", "deform", "pipe.obj", "--rest", "rest.vtu", "--to",
                          "rest.vtu", "-o", "link.obj")
        os.mkfifo(self.path / "pipe.vtu")
        self.assert_fails("pipe.vtu: is also an input (LATTICE|MESH|CURVE), and would be overwritten; "
                          "choose another name", "refine", "pipe.vtu", "-o", "pipe.vtu")

    def test_standard_input_as_two_inputs(self):
        (self.path / "a.vtu").symlink_to("/dev/stdin")
        reader, writer = os.pipe()  # stays open
        self.addCleanup(os.close, writer)
        self.addCleanup(os.close, reader)
        self.assert_fails("a.vtu: is given for --rest and for --to, but can be read only once, since it "
                          "is not a regular file; copy it to a file first", "deform", "model.obj", "--rest",
                          "a.vtu", "--to", "a.vtu", "-o", "out.obj", stdin=reader)

    def test_a_dash_is_no_name_of_standard_input(self):
        hint = ("To read one argument from standard input, make a link to /dev/stdin with the "
                "extension of the format, and name the link")
        for arguments, command in [
                ("--rest and --to", ["deform", "model.obj", "--rest", "-", "--to", "-", "-o", "o.obj"]),
                ("MODEL, --rest and --to", ["deform", "-", "--rest", "-", "--to", "-", "-o", "o.obj"]),
                ("LATTICE", ["shape", "merge", "-", "-", "-o", "o.vtu"]),
                ("--rest", ["bind", "model.obj", "--rest", "-", "-o", "o.espb"])]:
            self.assert_fails(f"-: does not exist (given for {arguments}). {hint}", *command)

    def test_a_pipe_as_one_input_is_read(self):
        os.mkfifo(self.path / "pipe.vtu")
        process = self.start("deform", "model.obj", "--rest", "rest.vtu", "--to", "pipe.vtu", "-n",
                             2, "-o", "out.obj", "--quiet")
        (self.path / "pipe.vtu").write_bytes(self.bytes("rest.vtu"))
        self.assertEqual(process.wait(timeout=120), 0)
        self.assertTrue((self.path / "out.obj").exists())

    def test_a_full_device(self):
        (self.path / "full.espb").symlink_to("/dev/full")
        self.assert_fails("full.espb: cannot write: No space left on device",
                          *self.bind("full.espb"))
        self.assert_fails("/dev/full: cannot write: No space left on device",
                          "deform", "model.obj", "--rest", "rest.vtu", "--to", "rest.vtu",
                          "-n", 2, "-o", "/dev/full")

    def test_a_full_disk(self):
        self.assert_nothing_is_lost_on_a_full_disk(*self.bind()[:-2], output="m.espb")

    def test_a_pipe_that_nobody_reads(self):
        reader, writer = os.pipe()
        os.close(reader)
        name = f"/dev/fd/{writer}"
        self.assert_fails(f"{name}: cannot write: Broken pipe", "stencils", "rest.vtu", "-n", 2,
                          "-o", name, pass_fds=[writer])
        os.close(writer)

    def test_standard_output_as_a_file_goes_on_where_that_is(self):
        with open(self.path / "log", "w") as log:
            print("before", file=log, flush=True)
            self.start("deform", "model.obj", "--rest", "rest.vtu", "--to", "rest.vtu", "-n", 2,
                       "-o", "/dev/stdout", stdout=log).wait(timeout=120)
            print("after", file=log)
        text = self.text("log")
        self.assertTrue(text.startswith("before\n# a comment\nv "), text[:50])
        self.assertEqual(text.count("\nv "), 500)
        self.assertIn("\npeak memory", text)
        self.assertTrue(text.endswith("after\n"))


class StandardStreams(FaultsTest):
    def shell(self, command, code):
        """Returns the standard error of a shell command in which $E is the program."""
        result = subprocess.run(["bash", "-c", command], cwd=self.path, text=True,
                                capture_output=True, timeout=120,
                                env={**os.environ, "E": program.ESPALIER})
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr

    def test_standard_output_that_cannot_be_written(self):
        error = "espalier: cannot write to standard output: "
        for to, cause in [(">/dev/full", "No space left on device"),
                          (">&-", "Bad file descriptor")]:
            # The output is smaller and larger than the buffer.
            for command in ["info rest.vtu -n 1", "info rest.vtu -n 3 --json", "--help"]:
                self.assertEqual(self.shell(f'"$E" {command} {to}', 1), error + cause + "\n")
        self.assertEqual(self.shell('"$E" refine rest.vtu -n 1 -o r.vtu --quiet >&-', 0), "")

    def test_a_reader_that_has_enough(self):
        reader, writer = os.pipe()
        os.close(reader)
        self.addCleanup(os.close, writer)
        # Like other filters, the program ends without a message when the reader closes the pipe.
        process = self.start("info", "rest.vtu", stdout=writer, stderr=subprocess.PIPE)
        self.assertEqual(process.communicate(timeout=120), (None, b""))
        self.assertEqual(process.returncode, -signal.SIGPIPE)
        # Python ignores the signal, and so do its children.
        self.assert_fails("cannot write to standard output: Broken pipe", "info", "rest.vtu",
                          stdout=writer, restore_signals=False)

    def test_standard_error_that_cannot_be_written(self):
        for to in ["2>/dev/full", "2>&-"]:
            self.assertEqual(self.shell(f'"$E" info none.vtu {to}', 1), "")
            self.assertEqual(self.shell(f'"$E" info {to}', 2), "")
            self.assertEqual(self.shell(f'"$E" info rest.vtu >/dev/full {to}', 1), "")

    def test_closed_streams_are_not_taken_for_files(self):
        self.run_program("refine", "rest.vtu", "-n", 1, "-o", "expected.vtu")
        for closed in [">&-", "2>&-", "<&- >&- 2>&-"]:
            self.shell(f'"$E" refine rest.vtu -n 1 -o r.vtu --quiet {closed}', 0)
            self.assertEqual(self.bytes("r.vtu"), self.bytes("expected.vtu"))


class Memory(FaultsTest):
    def test_too_little_of_it_is_one_line(self):
        self.put("r.vtu", "old")
        for kind, megabytes in [(resource.RLIMIT_AS, 150), (resource.RLIMIT_DATA, 20),
                                (resource.RLIMIT_DATA, 100)]:
            size = megabytes << 20
            self.assert_fails(re.compile(r"out of memory while refining: [0-9.]+ MB were in use at most; "
                                         r"the limit is [0-9.]+ [MGT]B \(--max-memory\)"),
                              "refine", "rest.vtu", "-n", 6, "--threads", 1, "-o", "r.vtu",
                              preexec_fn=lambda: resource.setrlimit(kind, (size, size)))

    def test_allocations_that_fail(self):
        if not FAILING_PRELOAD:
            self.skipTest("without the library for it")
        self.run_program("shape", "box", "-o", "one.vtu", "--quiet")
        self.write_model(icosphere_points(5))
        self.put("out.obj", "old")
        deform = ["deform", "model.obj", "--rest", "one.vtu", "--to", "one.vtu", "-n", 1, "-o",
                  "out.obj", "--threads", 1]
        count = self.allocations_of(*deform)
        # This includes the allocations before main().
        for number in range(1, count + 1, 251):
            self.assert_survives("one", number, *deform)
            self.assert_survives("all", number, *deform)
        # The report comes last.
        info = ["info", "one.vtu", "-n", 0, "--json"]
        count = self.allocations_of(*info)
        for number in range(count - 300, count + 1, 4):
            self.assert_survives("one", number, *info)

    def run_with(self, failing, number, *arguments):
        """Returns exit code and error of a run in which one allocation fails, or all from there on."""
        process = self.start(*arguments, text=True, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE,
                             env={**os.environ, "LD_PRELOAD": FAILING_PRELOAD,
                                  "ESPALIER_TEST_FAILING": f"{failing}:{number}"})
        error = process.communicate(timeout=120)[1]
        return process.returncode, error

    def allocations_of(self, *arguments):
        low, high = 1, 1_000_000
        while low < high:
            middle = (low + high) // 2
            if self.run_with("all", middle, *arguments)[0] == 0:
                high = middle
            else:
                low = middle + 1
        return low - 1

    def assert_survives(self, failing, number, *arguments):
        """Checks that files stay whole if memory runs out."""
        before = self.contents()
        result = self.run_with(failing, number, *arguments)
        if result != (0, ""):
            self.assertEqual(result[0], 1, (failing, number))
            # Parsing the command line and writing the report are not stages.
            self.assertRegex(result[1], r"^espalier: out of memory( while [a-z ]+)?: [0-9.]+ [kM]B were "
                                        r"in use at most(; the limit is .*)?\n$")
        after = self.contents()
        output = self.path / "out.obj"
        self.assertIn(after[output].count(b"\nv "), [0, 5])
        self.assertEqual({**after, output: b""}, {**before, output: b""})


if __name__ == "__main__":
    if len(sys.argv) > 3:
        FAILING_PRELOAD, SIGNAL_PRELOAD = map(os.path.abspath, sys.argv[2:4])
        del sys.argv[2:4]
    program.ESPALIER = os.path.abspath(sys.argv.pop(1))
    unittest.main()
