"""The style sheet of the page: on a screen, and printed."""

CSS = """
:root { color: #1d1d1f; background: #fff; }
body { font: 16px/1.5 "DejaVu Sans", Verdana, system-ui, sans-serif; margin: 0 auto;
  max-width: 62rem; padding: 1.5rem 1.25rem 4rem; }
h1 { font-size: 1.35rem; line-height: 1.35; margin: 0 0 .6rem; }
h2 { font-size: 1.1rem; margin: 2.4rem 0 .6rem; padding-top: .8rem; border-top: 1px solid #ddd; }
p { margin: .5rem 0; }
.verdict { font-size: 1.1rem; border-left: .35rem solid #0072B2; padding: .5rem .9rem;
  background: #f3f7fa; margin: .6rem 0; }
.verdict.unexplained { border-color: #D55E00; background: #fbf4ef; }
.verdict.adequate { border-color: #009E73; background: #f0f8f5; }
.set, figcaption, summary { color: #4a4a4f; font-size: .875rem; }
figure { margin: 1rem 0 1.4rem; }
figure svg { width: 100%; height: auto; display: block; }
figcaption { max-width: 52rem; margin-top: .3rem; }
table { border-collapse: collapse; font-size: .875rem; margin: .6rem 0; }
th, td { text-align: left; padding: .22rem .9rem .22rem 0; border-bottom: 1px solid #e4e4e4;
  vertical-align: top; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th { font-weight: 600; color: #4a4a4f; }
details { margin: .5rem 0; overflow-x: auto; }
summary { cursor: pointer; }
pre { background: #f5f5f5; padding: .7rem .9rem; overflow-x: auto; font-size: .85rem; }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  figure, table, pre { break-inside: avoid; }
  h2 { break-after: avoid; }
  .verdict { background: none; }
}
"""
