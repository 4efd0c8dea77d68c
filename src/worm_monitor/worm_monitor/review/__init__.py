"""The page on which a person looks through a trial and sets right what the tracker took wrongly."""
