# SPDX-License-Identifier: MIT
"""Tables of what was measured, in out/deploy."""
import os

FOLDER = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "out", "deploy"))


class Report:
    """A table that is written anew with every row, so that a test that fails leaves what there is."""

    def __init__(self, name, columns):
        self.path = os.path.join(FOLDER, name)
        self.columns = columns
        self.rows = []

    def add(self, *cells):
        self.rows.append([str(cell) for cell in cells])
        os.makedirs(FOLDER, exist_ok=True)
        with open(self.path, "w") as file:
            for row in [self.columns, ["---"] * len(self.columns), *self.rows]:
                file.write("| " + " | ".join(row) + " |\n")
