"""Parts of interactive HTML pages that need nothing else: the shell, samples, plots, spectra.

`shell` puts sections, scripts, samples and the plotting library into one file; `samples` packs
series of results; `library` has Plotly. The scripts beside them are plain functions:

| script | for the page |
|---|---|
| `samples.js` | decodes samples and the library when they are needed |
| `decimate.js`, `spectrum.js` | pure functions of arrays |
| `theme.js`, `paper.js` | light and dark colours, for CSS and plots; printing |
| `histories.js`, `panel.js`, `chooser.js` | plots over time with linked axes; the choice of them |
| `spectra.js` | spectra of what the plots show |
"""
