"""`python -m benchmarks`: ratios taken in one run, and errors on films with truth."""

from benchmarks import accuracy, analysis, boundary_walk, forecast, graph, tracker

if __name__ == "__main__":
    graph.main()
    tracker.main()
    analysis.main()
    boundary_walk.main()
    forecast.main()
    accuracy.main([])
