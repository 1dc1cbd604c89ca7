//! Style of pages, and the script that sorts their table.

/// Light and dark colours.
pub(super) const PALETTE: &str = "
:root { color-scheme: light dark; --ink: #1c1e21; --paper: #fbfbfa; --faint: #d9d9d6; --soft: #6a6d72; --bad: #b3261e;
  --good: #2e7d32; --card: #ffffff; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8e6; --paper: #16181a; --faint: #3a3d40; --soft: #a0a3a8;
  --bad: #ff8a80; --good: #81c784; --card: #1e2023; } }
";

/// Layout for narrow, wide and printed pages.
pub(super) const STYLE: &str = "* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 76rem; padding: 1rem; background: var(--paper); color: var(--ink);
  font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.5rem; margin: 0.5rem 0; } h2 { font-size: 1.15rem; margin: 0 0 0.4rem; } h3 { font-size: 0.9rem;
  margin: 0.8rem 0 0.2rem; color: var(--soft); font-weight: 600; } h1, h2, p, li { overflow-wrap: anywhere; }
a { color: inherit; }
.scroll { overflow-x: auto; } .all wbr { display: none; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 0.25rem 0.7rem; text-align: right; border-bottom: 1px solid var(--faint); white-space: nowrap; }
th:first-child, td:first-child, .left { text-align: left; }
th { font-weight: 600; } th[data-sorts] { cursor: pointer; }
.bad { color: var(--bad); } .good { color: var(--good); } .soft { color: var(--soft); }
.regressions { border-left: 4px solid var(--bad); padding: 0.1rem 1rem; margin: 1rem 0; }
section.material { background: var(--card); border: 1px solid var(--faint); border-radius: 6px; padding: 0.9rem;
  margin: 1rem 0; break-inside: avoid; }
.row { display: flex; flex-wrap: wrap; gap: 0.8rem 1.4rem; align-items: flex-start; }
figure { margin: 0; } figcaption { font-size: 0.8rem; color: var(--soft); text-align: center; }
figure img { width: 96px; height: 96px; display: block; }
.triple { display: flex; gap: 0.3rem; break-inside: avoid; } .triple figcaption { width: 96px; }
.row.large { margin-top: 0.6rem; } .large figure { width: min(160px, 46%); } .large img { width: 100%; height: auto; }
td.words { white-space: normal; min-width: 11rem; overflow-wrap: anywhere; }
@media (max-width: 32rem) { th, td { padding: 0.25rem 0.4rem; } .wraps td:first-child { white-space: normal; } }
.plot svg { width: 300px; max-width: 100%; height: auto; }
.sheet { display: flex; flex-wrap: wrap; gap: 0.6rem; } .sheet figcaption { width: 96px; overflow-wrap: anywhere; }
.scale { width: 12rem; height: 0.7rem; border: 1px solid var(--faint);
  background: linear-gradient(90deg, #06060e, #4a126e, #ba3254, #f78c1c, #fcfab4); }
ul { margin: 0.2rem 0; padding-left: 1.2rem; }
@media print { :root { color-scheme: light; --ink: #000; --paper: #fff; --card: #fff; --faint: #ccc; --soft: #444;
  --bad: #a00; --good: #060; }
  @page { margin: 14mm 12mm; }
  body { max-width: none; padding: 0; font-size: 9pt; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
  .scroll { overflow: visible; } th, td { padding: 0.15rem 0.35rem; font-size: 8pt; }
  .all th, .all td:first-child { white-space: normal; } .all wbr { display: inline; }
  td.words { min-width: 0; }
  section.material { break-inside: auto; padding: 0.6rem; } section.material table { break-inside: avoid; }
  h1, h2, h3, h2 + p, p:has(+ .row) { break-after: avoid; } .plot h3 { font-size: 7.5pt; min-height: 2.6em; }
  tr, ul, p, figure, .plot, .triple { break-inside: avoid; }
  p:has(.scale) { break-before: avoid; } .row { gap: 0.4rem 0.8rem; } figure img { width: 84px; height: 84px; }
  .large figure { width: 130px; } .large img { width: 100%; height: auto; } .triple figcaption, .sheet figcaption { width: 84px; }
  .plot { width: 31%; } .plot svg { width: 100%; } }
";

/// Sorts the table by the column whose head is clicked, numbers numerically.
pub(super) const SCRIPT: &str = "
document.querySelectorAll('th[data-sorts]').forEach((head) => head.addEventListener('click', () => {
  const table = head.closest('table'), body = table.tBodies[0], column = head.cellIndex;
  const down = head.dataset.sorts === 'up'; head.dataset.sorts = down ? 'down' : 'up';
  const value = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
  const order = (a, b) => { const [x, y] = [value(a), value(b)], d = x - y; return Number.isNaN(d) ? x.localeCompare(y) : d; };
  [...body.rows].sort((a, b) => down ? order(b, a) : order(a, b)).forEach((row) => body.append(row));
}));
";
