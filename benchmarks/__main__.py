"""`python -m benchmarks`: ratios taken in one run, and errors on films with truth."""

from benchmarks import accuracy, analysis, boundary_walk, graph, tracker

if __name__ == "__main__":
    graph.main()
    tracker.main()
    analysis.main()
    boundary_walk.main()
    accuracy.main()
