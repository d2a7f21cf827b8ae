"""Pictures for papers: of views and plots, at a stated size in millimetres, as SVG, PDF or PNG.

``figure_file`` writes what a painter draws; ``view_figure`` draws both views as they are shown; ``plot_figure`` the
plots; ``figure_dialog`` asks for part, size and resolution.
"""
