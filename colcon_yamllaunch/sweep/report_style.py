# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How the page about a sweep looks: by day, by night and on paper."""

STYLE = """\
:root {
  color-scheme: light dark;
  --page: #ffffff; --text: #1d2329; --faint: #5c6670; --line: #d9dee3;
  --card: #f6f8fa; --good: #1f6fd0; --bad: #c9372c; --link: #0b5cad;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14181c; --text: #e4e8ec; --faint: #9aa5b0; --line: #343c45;
    --card: #1c2228; --good: #6aa9f4; --bad: #ff7b6b; --link: #7db7ff;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; max-width: 68rem; padding: 1rem; line-height: 1.45;
  font: 1rem system-ui, sans-serif; color: var(--text);
  background: var(--page);
}
h1 { font-size: 1.5rem; margin: 0.5rem 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2rem 0 0.5rem; }
h3 { font-size: 1rem; margin: 0 0 0.4rem; overflow-wrap: anywhere; }
a { color: var(--link); }
p, figcaption { color: var(--faint); margin: 0.4rem 0; }
pre {
  background: var(--card); padding: 0.6rem 0.8rem; border-radius: 0.4rem;
  white-space: pre-wrap; overflow-wrap: anywhere; font-size: 0.85rem;
}
dl { display: grid; gap: 0.6rem;
  grid-template-columns: repeat(auto-fit, minmax(8rem, 1fr)); }
dl div { background: var(--card); border-radius: 0.4rem; padding: 0.6rem; }
dt { color: var(--faint); font-size: 0.85rem; }
dd { margin: 0; font-size: 1.3rem; font-weight: 600; }
.cards { display: grid; gap: 1rem; align-items: start;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 20rem), 1fr)); }
.card {
  border: 1px solid var(--line); border-radius: 0.5rem; padding: 0.8rem;
  min-width: 0; break-inside: avoid; margin: 0;
}
.warning { border-color: var(--bad); border-width: 2px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td {
  text-align: left; padding: 0.25rem 0.6rem 0.25rem 0; vertical-align: top;
  border-bottom: 1px solid var(--line); overflow-wrap: break-word;
  max-width: 26rem;
}
.card td:first-child { overflow-wrap: anywhere; min-width: 6rem; }
.wide td { min-width: 3.5rem; }
th { color: var(--faint); font-weight: 500; }
.number { text-align: right; font-variant-numeric: tabular-nums;
  white-space: nowrap; }
.wide .number { text-align: left; }
.share { width: 30%; min-width: 4rem; }
figcaption { font-size: 0.85rem; }
.bad { color: var(--bad); }
svg { display: block; width: 100%; height: auto; }
svg text { font: 11px system-ui, sans-serif; fill: var(--faint); }
svg .axis { stroke: var(--line); fill: none; }
svg .good { fill: var(--good); }
svg .rest { fill: var(--line); }
svg .mean { stroke: var(--text); stroke-width: 1.6; fill: none; }
svg .bad { stroke: var(--bad); stroke-width: 1.6; fill: none; }
summary { cursor: pointer; color: var(--link); }
@media print {
  :root {
    --page: #ffffff; --text: #000000; --faint: #444444; --line: #bbbbbb;
    --card: #ffffff; --good: #1f6fd0; --bad: #c9372c; --link: #000000;
  }
  body { max-width: none; padding: 0; font-size: 0.8rem;
    print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  .wide { overflow: visible; }
}
"""
