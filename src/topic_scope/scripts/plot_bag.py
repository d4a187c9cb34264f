#!/usr/bin/env python3
"""Plot numbers of a bag, or write them to a CSV file: see topic_scope.commands.plot_bag."""

from topic_scope.commands.plot_bag import main

if __name__ == "__main__":
    main()
