"""The class Node: names, lifetimes, what is opened when and closed when."""
