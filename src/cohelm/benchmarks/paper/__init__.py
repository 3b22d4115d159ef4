"""Experiments of Xu et al., compared with the paper's own figures."""
