#!/usr/bin/python3
"""Reads a session's results with numpy alone: mean and standard error of each quantity over the shots that count.

    host/examples/read_session.py sessions/today

results.csv-metadata.json beside the table names each column with its type, unit and meaning.
"""

import csv
import json
import pathlib
import sys

import numpy


def read_table(path):
    """The table as a dictionary from column to array; what could not be had is NaN, or an empty text. And its units."""
    metadata = json.loads(path.with_name(path.name + "-metadata.json").read_text(encoding="utf-8"))
    described = metadata["tableSchema"]["columns"]
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    table, units = {}, {}
    for column in described:
        name = column["name"]
        cells = [row[name] for row in rows]
        if column["datatype"] == "number":
            table[name] = numpy.array([float(cell) if cell else numpy.nan for cell in cells])
        else:
            table[name] = numpy.array(cells, dtype=str)
        units[name] = column.get("schema:unitCode", "")
    return table, units


def mean_and_standard_error(values):
    """Of the values that are there; NaN where there are too few."""
    values = values[~numpy.isnan(values)]
    mean = values.mean() if len(values) > 0 else numpy.nan
    error = values.std(ddof=1) / numpy.sqrt(len(values)) if len(values) > 1 else numpy.nan
    return len(values), mean, error


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    table, units = read_table(pathlib.Path(sys.argv[1]) / "results.csv")
    counts = table["rejected"] == ""
    print(f"{counts.sum()} of {len(counts)} shots count")
    print(f"{'quantity':18} {'unit':6} {'n':>3} {'mean':>12} {'standard error':>15}")
    for name in table:
        if "sd_" + name not in table:
            continue
        n, mean, error = mean_and_standard_error(table[name][counts])
        print(f"{name:18} {units[name]:6} {n:3} {mean:12.5g} {error:15.2g}")


if __name__ == "__main__":
    main()
