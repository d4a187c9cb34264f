#!/usr/bin/env python3
"""Plot what a bag holds, or write it to a CSV file: see topic_scope.bag.plot_bag_command."""

from topic_scope.bag.plot_bag_command import main

if __name__ == "__main__":
    main()
