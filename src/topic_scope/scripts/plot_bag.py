#!/usr/bin/env python3
"""Plot what a bag holds, or write it to a CSV file: see topic_scope.plot_bag_command."""

from topic_scope.plot_bag_command import main

if __name__ == "__main__":
    main()
