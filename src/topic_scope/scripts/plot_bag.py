#!/usr/bin/env python3
"""Plot what a bag holds, or write it to a CSV file: see topic_scope.commands.plot_bag."""

from topic_scope.commands.plot_bag import main

if __name__ == "__main__":
    main()
