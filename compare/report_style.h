// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a report looks; not installed.
namespace espalier::compare {

/// Holds no '<' and no '&', so that the page is well-formed.
inline constexpr const char* kReportStyle = R"(
:root {
  color-scheme: light dark;
  --page: #ffffff; --text: #1c2128; --soft: #59636e; --line: #d5dae0; --panel: #f4f6f8;
  --link: #0b5cad; --good: #17653a; --good-panel: #e8f4ec; --bad: #a3211b; --bad-panel: #fcebe9;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14171b; --text: #e3e7eb; --soft: #9aa5b1; --line: #353c45; --panel: #1d2126;
    --link: #7ab7f5; --good: #7fd3a0; --good-panel: #16291e; --bad: #ff9b91; --bad-panel: #3a1b19;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2.5rem 1.5rem 4rem; max-width: 78rem;
  background: var(--page); color: var(--text);
  font: 1rem/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif;
}
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 1.25rem; text-wrap: balance; }
h2 { font-size: 1.25rem; margin: 2.75rem 0 .5rem; }
p { margin: .5rem 0; max-width: 52rem; text-wrap: pretty; }
a { color: var(--link); text-underline-offset: .15em; }
.note, .theirs, figcaption { color: var(--soft); }
.note { font-size: .925rem; }
code {
  font: .9em ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
  overflow-wrap: anywhere;
}
.verdict {
  margin: 0 0 1.25rem; padding: .8rem 1.1rem; max-width: none; font-size: 1.1rem;
  border-left: .3rem solid; border-radius: .25rem;
}
.verdict.good { background: var(--good-panel); border-color: var(--good); }
.verdict.bad { background: var(--bad-panel); border-color: var(--bad); }
.good > strong, td.good { color: var(--good); }
.bad > strong, td.bad { color: var(--bad); }
td.bad, td.good { font-weight: 600; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .25rem 1.25rem; margin: 0; }
dt { color: var(--soft); }
dd { margin: 0; min-width: 0; }
.scroll { overflow-x: auto; margin: .9rem 0; }
table {
  border-collapse: collapse; width: 100%;
  font-size: .925rem; font-variant-numeric: tabular-nums;
}
th, td { padding: .32rem .7rem; text-align: left; vertical-align: top; }
th:first-child, td:first-child { padding-left: .4rem; }
thead th {
  color: var(--soft); font-weight: 600;
  border-bottom: 1px solid var(--line); vertical-align: bottom;
}
tbody { border-bottom: 1px solid var(--line); }
tbody th { font-weight: 600; }
th[scope=rowgroup] { min-width: 9rem; max-width: 18rem; overflow-wrap: break-word; }
.number { text-align: right; white-space: nowrap; }
.value { white-space: nowrap; }
.words { min-width: 9rem; }
td.note { min-width: 18rem; }
.verdicts { white-space: nowrap; }
.theirs { display: block; font-size: .85em; font-weight: 400; }
.figures {
  display: grid; gap: 1.5rem; margin-top: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(27rem, 100%), 1fr));
}
figure {
  margin: 0; padding: .9rem 1rem 1rem; background: var(--panel); border-radius: .5rem;
  content-visibility: auto; contain-intrinsic-size: auto 30rem;
}
figure:target { outline: 2px solid var(--link); }
figure svg { display: block; width: 100%; height: auto; color: var(--text); }
figcaption { margin-top: .6rem; font-size: .925rem; }
figcaption strong { color: var(--text); font-size: 1rem; overflow-wrap: anywhere; }
@media print {
  :root {
    --page: #ffffff; --text: #000000; --soft: #444444; --line: #bbbbbb; --panel: #ffffff;
    --link: #000000; --good: #000000; --good-panel: #ffffff; --bad: #000000; --bad-panel: #ffffff;
  }
  @page { margin: 12mm; }
  html { font-size: 9pt; }
  body { padding: 0; max-width: none; }
  table { font-size: 7.5pt; }
  td.note { font-size: 1em; }
  th, td { padding: .15rem .3rem; }
  .words, td.note, th[scope=rowgroup] { min-width: 0; }
  a { text-decoration: none; }
  .scroll { overflow: visible; }
  thead { display: table-header-group; }
  tr, figure, .verdict { break-inside: avoid; }
  h2, h2 + .note { break-after: avoid; }
  .figures { grid-template-columns: 1fr 1fr; }
  figure { content-visibility: visible; border: 1px solid var(--line); }
  svg { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)";

}  // namespace espalier::compare
