# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of scripts/report.py; report.sh runs them."""
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "report.py"
sys.path.insert(0, str(SCRIPT.parent))
sys.dont_write_bytecode = True
import report  # noqa: E402


def rows(header, *lines):
    return [dict(zip(header.split(","), line.split(","))) for line in lines]


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_csv_is_read_and_written_with_quotes(self):
        path = self.folder / "table.csv"
        report.write(path, ["a", "b"], [["1", 'x, "y"']])
        self.assertEqual(path.read_text(), 'a,b\n1,"x, ""y"""\n')
        table = report.read(path)
        self.assertEqual(table, [{"a": "1", "b": 'x, "y"'}])
        self.assertEqual(report.markdown(table), '| a | b |\n|---|---|\n| 1 | x, "y" |\n')
        self.assertEqual(report.where(table, a="2"), [])
        with self.assertRaises(KeyError):
            report.where(table, c="2")
        path.write_text("a,b\n1\n")
        with self.assertRaisesRegex(ValueError, "table.csv: row 1 has 1 cells"):
            report.read(path)
        path.write_text("a,b\n")
        self.assertEqual(report.read(path), [])
        self.assertEqual(report.read(self.folder / "nothing.csv"), [])
        self.assertEqual(report.fixed(float("nan"), 2), "-")

    def test_bars_tell_what_is_missed(self):
        tables = {
            "table1": rows("mesh,noise,method,aep,seconds", "m,both,20-NN,8,10", "m,both,4-pass,9,1",
                           "m,both,default,2,1"),
            "density": rows("mesh,points,4-pass,20-NN", "m,1000,3.1,3", "m,9000,3,-"),  # stopped: no bar
            "isolated": rows("sampling,graph,unanchored_percent,plain_aep,aep",
                             "uniform,5-NN,0,8,8",  # no such parts to be expected there
                             "scan lines,5-NN,0.1,9,8"),
            "table2": rows("graph,solver,points,status,total_s", "4-pass,CG,1000,ok,1",
                           "4-pass shared,CHOLMOD,1000,ok,1", "20-NN,SuiteSparseQR,1000,time limit,-",
                           "4-pass,SuiteSparseQR,1000,ok,3", "4-pass shared,SuiteSparseQR,1000,ok,2")}
        bars = report.check_bars(tables)
        expected = ["MISSED",  # 9 is more than 5 % above 8
                    "met",  # default
                    "met", "met", "met", "met", "met", "MISSED"]
        self.assertEqual([bar.split(":")[0] for bar in bars], expected)

    def test_growth_is_between_the_smallest_and_the_largest_size_that_ended_in_time(self):
        growth = report.growth_of(rows("graph,solver,points,status,total_s,us_per_point",
                                       "4-pass,CHOLMOD,1000,ok,1,1000", "4-pass,CHOLMOD,10000,ok,100,10000",
                                       "4-pass,CHOLMOD,100000,time limit,-,-", "DT,CHOLMOD,1000,time limit,-,-"))
        self.assertEqual(len(growth), 1)
        self.assertEqual(growth[0]["to"], "10000")
        self.assertEqual(growth[0]["exponent"], "2.00")

    def test_plot_is_a_picture_or_says_what_is_missing(self):
        self.assertEqual(report.plot(self.folder, "line", "plot x"), "")
        self.assertEqual((self.folder / "line.png").read_bytes()[:4], b"\x89PNG")
        self.assertIn("gnuplot failed", report.plot(self.folder, "wrong", "plot no_such_file_or_function("))
        with unittest.mock.patch.dict("os.environ", PATH="/nowhere"):
            self.assertIn("gnuplot-nox", report.plot(self.folder, "none", "plot x"))

    def test_folder_without_tables_is_an_error(self):
        run = subprocess.run([sys.executable, SCRIPT, self.folder], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 1)
        self.assertIn("has no table", run.stderr)


unittest.main()
