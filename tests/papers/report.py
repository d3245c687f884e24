"""A report as Markdown and as an HTML page, with pictures by gnuplot."""

import html
import pathlib
import subprocess

COLOURS = ("#999999", "#d55e00", "#0072b2", "#009e73", "#cc79a7")
STYLE = ("body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222;background:#fff}"
         "table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.2em .7em;text-align:left}"
         "th{background:#eee}img{max-width:100%}.missed{color:#b00;font-weight:bold}")


def gnuplot(path, script):
    """Draws an SVG. Without gnuplot there is no picture, and that is all."""
    head = ("set terminal svg size 900,380 dynamic font 'sans-serif,12' background '#ffffff'\nset encoding utf8\n"
            f"set output '{path}'\nset grid lc rgb '#dddddd'\nset tics nomirror\nset key top left\n")
    try:
        return subprocess.run(["gnuplot", "-"], input=head + script, text=True, capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


def bars(rows, names):
    """A script: groups of bars. rows: label and one height for each name."""
    data = "\n".join(" ".join(str(c) for c in row) for row in rows)
    plots = ", ".join(f"$d using {i + 2}:xtic(1) title '{n}' lc rgb '{COLOURS[i]}'" for i, n in enumerate(names))
    return (f"$d << END\n{data}\nEND\nset style data histogram\nset style histogram cluster gap 1\nset style fill solid 0.8 noborder\n"
            f"set yrange [0:*]\nplot {plots}\n")


def lines(curves, limit=None):
    """A script: curves of (name, x, y)."""
    data, plots = "", []
    for i, (name, x, y) in enumerate(curves):
        data += f"$d{i} << END\n" + "\n".join(f"{a:.2f} {b:.5g}" for a, b in zip(x, y)) + "\nEND\n"
        plots.append(f"$d{i} using 1:2 with lines lw 1.3 lc rgb '{COLOURS[i]}' title '{name}'")
    scale = f"set yrange [-{limit}:{limit}]\n" if limit else ""
    return data + scale + "plot " + ", ".join(plots) + "\n"


class Report:
    def __init__(self, folder, title):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.title = title
        self.md, self.html = [], []
        self.reached, self.missed, self.close = [], [], []

    def heading(self, text, level=2):
        self.md.append(f"{'#' * level} {text}\n")
        self.html.append(f"<h{level}>{html.escape(text)}</h{level}>")
        print(f"papers: {text}", flush=True)

    def text(self, text):
        self.md.append(text + "\n")
        self.html.append(f"<p>{html.escape(text)}</p>")

    def table(self, head, rows):
        def line(cells):
            return "| " + " | ".join(str(c) for c in cells) + " |"

        self.md.append("\n".join([line(head), line("---" for _ in head)] + [line(row) for row in rows]) + "\n")
        body = "".join("<tr>" + "".join(f"<td{' class=missed' if c == 'MISSED' else ''}>{html.escape(str(c))}</td>" for c in row) + "</tr>"
                       for row in rows)
        self.html.append("<table><tr>" + "".join(f"<th>{html.escape(str(c))}</th>" for c in head) + f"</tr>{body}</table>")

    def verdict(self, reached, what, close=False, judged=True):
        """A figure that furrow is to reach. close: not reached, but no further off than chance explains."""
        if not judged:
            return ""
        (self.reached if reached else self.close if close else self.missed).append(what)
        return "reached" if reached else "within chance" if close else "MISSED"

    def picture(self, name, caption, script):
        if gnuplot(self.folder / f"{name}.svg", script):
            self.md.append(f"![{caption}]({name}.svg)\n\n*{caption}*\n")
            self.html.append(f'<figure><img src="{name}.svg" alt="{html.escape(caption)}">'
                             f"<figcaption>{html.escape(caption)}</figcaption></figure>")

    def write(self):
        total = len(self.reached) + len(self.missed) + len(self.close)
        summary = f"{len(self.reached)} of {total} figures reached"
        if self.close:
            summary += f", {len(self.close)} within chance ({'; '.join(self.close)})"
        summary += "." if not self.missed else f". Missed: {'; '.join(self.missed)}."
        print(f"papers: {summary}")
        (self.folder / "REPORT.md").write_text("\n".join([f"# {self.title}\n", summary + "\n"] + self.md))
        (self.folder / "REPORT.html").write_text(
            f"<!DOCTYPE html><html lang=en><meta charset=utf-8><title>{self.title}</title><style>{STYLE}</style>"
            f"<h1>{self.title}</h1><p>{html.escape(summary)}</p>" + "\n".join(self.html) + "</html>\n")
