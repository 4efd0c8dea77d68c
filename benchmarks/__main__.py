"""`python -m benchmarks`: ratios taken in one run, and errors on films with truth."""

from benchmarks import accuracy, analysis, graph, tracker

if __name__ == "__main__":
    graph.main()
    tracker.main()
    analysis.main()
    accuracy.main()
