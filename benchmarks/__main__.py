"""`python -m benchmarks`: every benchmark, each a table of ratios taken in one run."""

from benchmarks import analysis, graph, tracker

if __name__ == "__main__":
    graph.main()
    tracker.main()
    analysis.main()
