"""`python -m benchmarks`: every benchmark, each a table of ratios taken in one run."""

from benchmarks import analysis, graph

if __name__ == "__main__":
    graph.main()
    analysis.main()
