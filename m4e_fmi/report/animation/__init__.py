"""Animations as HTML pages that need nothing else: of one model, and of coupled systems.

`scene` describes what is shown, in text that results carry; `of_model` makes it of a model,
`frames` the numbers of each frame from results. `page` puts them together with `part.html`,
`part.css` and `player.js`, which draws them. `results_page` is the way from a file of results to
its page.
"""
